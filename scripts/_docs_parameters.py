"""The reference of all parameters, written from the configuration dataclasses."""

from __future__ import annotations

import functools
import math
import typing
from collections.abc import Iterator
from dataclasses import MISSING, Field

from floor_perception.config import (
    CameraNodeConfig,
    FloorDetectorConfig,
    FloorNodeConfig,
    MarkerNodeConfig,
)
from floornav_common.config import range_text
from floornav_common.config_files import parameter_fields
from floornav_common.frames import FrameConfig
from floornav_common.live_view.config import LiveViewConfig
from floornav_common.ros.node import ProcessConfig
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from multi_localizer.floor_node_config import FloorLocalizerConfig, FloorPoseConfig
from multi_localizer.landmark_config import LandmarkConfig, LandmarkNodeConfig, LandmarkTimeConfig
from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_localizer_node_config import StereoLocalizerNodeConfig
from multi_localizer.stereo_pairs_config import StereoPairsConfig
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_node_config import TeamNodeConfig, TeamTimingConfig
from sim_bridge.camera_config import OmniCameraConfig, StereoConfig
from sim_bridge.config import (
    DriveConfig,
    LaserConfig,
    OdometryConfig,
    RouteConfig,
    SimBridgeConfig,
    WheelConfig,
)
from sim_bridge.robot_model import RobotModel, load_robot, robot_names
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.world import RobotPlacement
from sjmc_planner.config import LocalPlannerConfig, SendGoalConfig
from sjmc_planner.wavefront_config import WavefrontConfig

NODES: dict[str, tuple[type, ...]] = {
    "grid_mapper grid_mapper": (
        GridMapperNodeConfig, GridMapperConfig, FrameConfig, ProcessConfig,
    ),
    "floor_perception floor_detector": (
        CameraNodeConfig, FloorNodeConfig, FloorDetectorConfig, FrameConfig, ProcessConfig,
    ),
    "floor_perception marker_detector": (
        CameraNodeConfig, MarkerNodeConfig, FrameConfig, ProcessConfig,
    ),
    "multi_localizer floor_localizer": (
        FloorLocalizerConfig, FloorPoseConfig, FrameConfig, ProcessConfig,
    ),
    "multi_localizer landmark_localizer": (
        LandmarkNodeConfig, LandmarkConfig, LandmarkTimeConfig, FrameConfig, ProcessConfig,
    ),
    "multi_localizer stereo_localizer": (
        StereoLocalizerNodeConfig, StereoLocalizerConfig, FrameConfig, ProcessConfig,
    ),
    "multi_localizer stereo_matcher": (StereoPairsConfig, StereoMatcherConfig, ProcessConfig),
    "multi_localizer team_localizer": (
        TeamNodeConfig, TeamTimingConfig, TeamConfig, FrameConfig, ProcessConfig,
    ),
    "floornav_common live_view": (LiveViewConfig, FrameConfig, ProcessConfig),
    "sim_bridge sim_bridge": (SimBridgeConfig, FrameConfig, ProcessConfig),
    "sim_bridge route_follower": (RouteConfig, ProcessConfig),
    "sjmc_planner local_planner": (LocalPlannerConfig, FrameConfig, ProcessConfig),
    "sjmc_planner send_goal": (SendGoalConfig, ProcessConfig),
    "sjmc_planner wavefront_planner": (WavefrontConfig, FrameConfig, ProcessConfig),
}  # fmt: skip
"""Every node, as `ros2 run` names it, and what it declares."""

ROBOT_FILE: dict[str, type] = {
    "drive": DriveConfig, "wheels": WheelConfig, "odometry": OdometryConfig, "laser": LaserConfig,
    "sonar": SonarConfig, "omni": OmniCameraConfig, "stereo": StereoConfig,
}  # fmt: skip
"""The groups of a robot file; a world's `overrides` changes single keys of them."""

HEAD = """\
# Parameters

Written by `python3 scripts/make_docs.py parameters` from the dataclasses that the nodes read; do
not edit by hand.

Set one with `-p NAME:=VALUE` after `--ros-args`, or all from a file with `--params-file FILE`. A
name that a node does not know, and a value out of range, stop it at the start with one line that
says so (exit code 2). An integer does for a number with decimals. What is not marked *fixed* can
be changed while the node runs (`ros2 param set`).

`scripts/map_bag.py --config FILE` takes the parameters of `grid_mapper` from the same file; those
of the node alone have no effect there.

Every node also takes `use_sim_time` and, for each of its topics, the standard quality-of-service
overrides `qos_overrides.<topic>.<publisher or subscription>.<policy>`, where the policy is
`history`, `depth`, `reliability` or `durability`.
"""
ROBOT_KEYS = """\
| key | meaning |
| --- | --- |
| `urdf` | File beside it with shapes and the links that sensors sit on. |
| `footprint_m` | Corners of the outline on the floor, in `base_link`, in order. |
| `height_m` | Height of the whole robot. |
| `drive`, `wheels`, `odometry`, `laser`, `sonar`, `omni`, `stereo` | Groups, below. |
"""
TABLE_HEAD = (
    "| name | default | unit | range | | meaning |\n| --- | --- | --- | --- | --- | --- |\n"
)


def parameter_page() -> str:
    """Return the text of docs/parameters.md."""
    parts = [HEAD]
    for node, classes in NODES.items():
        parts.append(f"## `{node}`\n")
        parts.extend(f"{_title(c)}\n\n{_table(c)}" for c in classes)
    parts.append("## Robot files\n")
    parts.append(
        "Not parameters but keys of `ros_ws/src/sim_bridge/sim_bridge/robots/*.yaml`, and of"
        " `overrides` in a world file: `overrides: {laser: {num_beams: 1081}}`. A group that the"
        " file does not name is absent (`laser`, `sonar`, `omni`, `stereo`) or has its defaults"
        " (`drive`, `wheels`, `odometry`); `laser: {}` is one of defaults, `laser: null` takes it"
        " away.\n"
    )
    parts.append(ROBOT_KEYS)
    parts.append("### Robots\n\n" + _robots())
    parts.extend(f"{_title(c)}\n\n{_table(c, group)}" for group, c in ROBOT_FILE.items())
    return "\n".join(parts)


def _robots() -> str:
    rows = []
    for name in robot_names():
        model = load_robot(RobotPlacement(model=name, position_m=(0.0, 0.0)))
        c = model.config
        drive = "omnidirectional" if c.drive.is_omnidirectional else "differential"
        speed = f"{c.drive.max_speed_m_s:g} m/s, {c.drive.max_yaw_rate_rad_s:g} rad/s"
        rows.append(f"| `{name}` | {drive} | {speed} | {_sensors(model)} |\n")
    return "| model | drive | fastest | sensors |\n| --- | --- | --- | --- |\n" + "".join(rows)


def _sensors(model: RobotModel) -> str:
    c, found = model.config, []
    if c.laser is not None:
        opening = math.degrees(c.laser.fov_rad)
        found.append(
            f"laser: {c.laser.num_beams} beams over {opening:.0f} deg to {c.laser.range_max_m:g} m"
        )
    if c.sonar is not None:
        found.append(f"{c.sonar.count} sonars to {c.sonar.range_max_m:g} m")
    if c.omni is not None:
        found.append(f"mirror camera {c.omni.width_px} x {c.omni.height_px}")
    if c.stereo is not None:
        pairs = " and ".join(c.stereo.pairs)
        found.append(f"stereo {pairs}, {c.stereo.width_px} x {c.stereo.height_px}")
    return "; ".join(found) or "none"


def documented_names(node: str) -> set[str]:
    """Return the names of the parameters that the page lists for a node."""
    return {name for c in NODES[node] for name in parameter_fields(c)}


def _title(config_class: type) -> str:
    return "### " + (config_class.__doc__ or "").strip().splitlines()[0].rstrip(".")


def _table(config_class: type, group: str = "") -> str:
    return TABLE_HEAD + "".join(
        f"| {' | '.join(cells)} |\n" for cells in _rows(config_class, group)
    )


def _rows(config_class: type, group: str) -> Iterator[list[str]]:
    for name, (field, _) in parameter_fields(config_class, group).items():
        own = name.removeprefix(f"{group}.") if group else name
        default = functools.reduce(getattr, own.split("."), config_class())
        yield [
            f"`{name}`", f"`{_as_yaml(default)}`", field.metadata.get("unit") or "",
            range_text(field), "fixed" if field.metadata.get("read_only") else "", _doc(field),
        ]  # fmt: skip


def _doc(field: Field[typing.Any]) -> str:
    assert field.default is not MISSING
    return str(field.metadata["doc"]).replace("|", "\\|")


def _as_yaml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return "[" + ", ".join(_as_yaml(v) for v in value) + "]"
    if isinstance(value, float):
        return f"{value:.6g}" if value != int(value) else f"{value:.1f}"
    return '""' if value == "" else str(value)
