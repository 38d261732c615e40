"""Robot files: a YAML of figures beside a URDF of shapes and sensor places."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from sim_bridge.camera_config import OmniCameraConfig, StereoConfig, optical_frame
from sim_bridge.config import DriveConfig, LaserConfig, OdometryConfig, WheelConfig
from sim_bridge.schema import WorldError, build, load_yaml
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.world import RobotPlacement

_VIEWPOINT_TOL_M = 5e-4


@dataclass(frozen=True, kw_only=True)
class RobotFile:
    """Schema of a file in `robots/`."""

    urdf: str
    footprint_m: tuple[tuple[float, float], ...]
    height_m: float
    drive: DriveConfig = DriveConfig()
    wheels: WheelConfig = WheelConfig()
    odometry: OdometryConfig = OdometryConfig()
    laser: LaserConfig | None = None
    sonar: SonarConfig | None = None
    omni: OmniCameraConfig | None = None
    stereo: StereoConfig | None = None

    def __post_init__(self) -> None:
        if self.drive.is_omnidirectional and not self.wheels.bearings_deg:
            raise ValueError("drive.is_omnidirectional needs wheels.bearings_deg")
        if not self.height_m > 0.0:
            raise ValueError(f"height_m must be > 0, got {self.height_m:g}")
        corners = np.array(self.footprint_m).reshape(-1, 2)
        edges = np.roll(corners, -1, axis=0) - corners
        after = np.roll(edges, -1, axis=0)
        bends = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
        if len(corners) < 3 or not ((bends > 1e-9).all() or (bends < -1e-9).all()):
            raise ValueError(
                f"footprint_m must be 3 or more corners of a convex shape, got {corners.tolist()}"
            )

    @property
    def sonar_frames(self) -> tuple[str, ...]:
        """The links its sonars sit on, in the order of their numbers."""
        sonar = self.sonar
        return () if sonar is None else tuple(f"{sonar.frame}{k}" for k in range(sonar.count))


@dataclass(frozen=True)
class RobotModel:
    """A robot file with its URDF read.

    Attributes:
        config: The robot file.
        urdf_path: The URDF.
        urdf: Its text, for `robot_description`.
        mounts: `T_base_link` of each link fixed to `base_link`, (4, 4), by link name.
    """

    config: RobotFile
    urdf_path: Path
    urdf: str
    mounts: dict[str, np.ndarray]

    @property
    def laser_m(self) -> tuple[float, float] | None:
        """Where the laser is in the base frame, x and y, m; None if there is none."""
        if self.config.laser is None:
            return None
        x, y = self.mounts[self.config.laser.frame][:2, 3]
        return float(x), float(y)

    def baseline(self, pair: str) -> float:
        """Return how far the right camera of a stereo pair is from the left one, m."""
        left, right = (self.mounts[optical_frame(pair, side)] for side in ("left", "right"))
        return float((np.linalg.inv(left) @ right)[0, 3])


def robot_names() -> list[str]:
    """Return the names of the robots in the package, sorted."""
    folder = resources.files("sim_bridge") / "robots"
    return sorted(f.name[: -len(".yaml")] for f in folder.iterdir() if f.name.endswith(".yaml"))


def load_robot(placement: RobotPlacement) -> RobotModel:
    """Load the robot that a world names, with the world's overrides.

    Raises:
        WorldError: Unknown model, bad key, or a sensor on a link that the URDF does not have.
    """
    if placement.model not in robot_names():
        known = ", ".join(robot_names())
        raise WorldError(f"no robot model named {placement.model!r}; there are: {known}")
    folder = Path(str(resources.files("sim_bridge") / "robots"))
    data = _merged(load_yaml(folder / f"{placement.model}.yaml"), placement.overrides)
    config = build(RobotFile, data, f"robot {placement.model}")
    urdf_path = folder / config.urdf
    try:
        urdf = urdf_path.read_text(encoding="utf-8")
    except OSError as error:
        raise WorldError(
            f"robot {placement.model}: urdf {config.urdf!r}: {error.strerror}"
        ) from error
    mounts = _fixed_mounts(urdf)
    lasers = () if config.laser is None else (config.laser.frame,)
    omnis = () if config.omni is None else (config.omni.frame,)
    stereos = () if config.stereo is None else config.stereo.frames
    for frame in (*lasers, *config.sonar_frames, *omnis, *stereos):
        if frame not in mounts:
            raise WorldError(f"robot {placement.model}: no link {frame!r} in its URDF")
    if config.omni is not None:
        _require_viewpoint(placement.model, config.omni, mounts[config.omni.frame])
    return RobotModel(config, urdf_path, urdf, mounts)


def _require_viewpoint(robot: str, omni: OmniCameraConfig, T_base_camera: np.ndarray) -> None:
    """Check that a mirror is upright and where its figures say."""
    height = omni.camera().viewpoint_height
    if abs(T_base_camera[2, 3] - height) > _VIEWPOINT_TOL_M or T_base_camera[2, 2] < 1.0 - 1e-9:
        raise WorldError(
            f"robot {robot}: {omni.frame!r} must be upright at the mirror's viewpoint, "
            f"{height:.4f} m above base_link, got {T_base_camera[2, 3]:.4f} m"
        )


def _merged(data: dict[str, Any], overrides: dict[str, Any]) -> dict[str, Any]:
    merged = dict(data)
    for key, value in overrides.items():
        old = merged.get(key)
        both = isinstance(old, dict) and isinstance(value, dict)
        merged[key] = _merged(old, value) if both else value  # type: ignore[arg-type]
    return merged


def _fixed_mounts(urdf: str) -> dict[str, np.ndarray]:
    """Return the pose in base_link of every link reached over fixed joints."""
    mounts = {"base_link": np.eye(4)}
    joints = [j for j in ElementTree.fromstring(urdf).findall("joint") if j.get("type") == "fixed"]
    for _ in joints:
        for joint in joints:
            parent, child = joint.find("parent"), joint.find("child")
            if parent is None or child is None or parent.get("link") not in mounts:
                continue
            mounts[str(child.get("link"))] = mounts[str(parent.get("link"))] @ _origin(joint)
    return {link: T for link, T in mounts.items() if link != "base_link"}


def _origin(joint: ElementTree.Element) -> np.ndarray:
    T = np.eye(4)
    origin = joint.find("origin")
    if origin is not None:
        T[:3, 3] = [float(v) for v in origin.get("xyz", "0 0 0").split()]
        rpy = [float(v) for v in origin.get("rpy", "0 0 0").split()]
        T[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    return T
