"""Every value of localization by landmarks; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate
from multi_localizer.motion_config import MotionConfig


@dataclass(frozen=True, kw_only=True)
class LandmarkConfig:
    """Pose from bearings of landmarks, and distances where the floor shows them."""

    bearing_sd_rad: float = param(0.01, "Deviation of a bearing.", unit="rad", gt=0.0, le=0.5)
    floor_offset_px: float = param(
        1.0,
        "How far before a foot the floor ends in the mask: pixels that are part landmark.",
        unit="px",
    )
    floor_sd_px: float = param(
        0.8, "Deviation of the floor's end along a ray, in pixels of the mask.", unit="px", gt=0.0
    )
    gate_sd: float = param(
        4.0, "A landmark farther off than so many deviations is left out.", gt=1.0
    )
    max_position_sd_m: float = param(
        0.5, "No pose is given if its position is known less well.", unit="m", gt=0.0
    )
    max_yaw_sd_rad: float = param(
        0.2, "No pose is given if its yaw is known less well.", unit="rad", gt=0.0
    )
    min_spare: int = param(
        1,
        "How many more bearings and distances must agree than the three numbers a pose needs. "
        "With 0 a pose of three is sent too: one false bearing among them does not show.",
        ge=0, le=20,
    )  # fmt: skip
    ambiguity_sd: float = param(
        3.0,
        "Two poses are told apart if the squared deviations of the better are less by the square "
        "of this.",
        ge=0.0,
    )  # fmt: skip
    max_tries: int = param(
        3000, "Most combinations of bearings and landmarks that are tried.", ge=1, le=100_000
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class LandmarkTrackConfig(MotionConfig):
    """Which poses follow from each other, view by view."""

    settle_views: int = param(
        3, "A pose is given when so many views, one after the other, have shown it.", ge=1, le=100
    )
    lost_after_s: float = param(
        0.5,
        "Poses that do not follow from the last one and the motion are believed after this, if "
        "settle_views of them agree: carried away.",
        unit="s", ge=0.0, le=10.0,
    )  # fmt: skip
    forget_s: float = param(
        5.0, "A pose that no view has shown for so long does not count any more.", unit="s",
        gt=0.0, le=60.0,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class LandmarkTimeConfig:
    """Poses over time."""

    track: LandmarkTrackConfig = LandmarkTrackConfig()

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class LandmarkNodeConfig:
    """The node `landmark_localizer`."""

    landmarks: str = param(
        "middle_size_field", "YAML of the landmarks, or the name of one of the package.",
        read_only=True,
    )  # fmt: skip
    method: str = param(
        "bearings",
        "`bearings` alone (method 1), or `floor`: distances where the floor's mask ends too "
        "(method 2).",
        choices=("bearings", "floor"), read_only=True,
    )  # fmt: skip
    camera_model: str = param(
        "soccer_middle_size",
        "YAML of the camera, or the name of one brought along; only `method: floor` needs it.",
        read_only=True,
    )  # fmt: skip
    floor_frame: str = param(
        "omni_camera_floor",
        "Frame below the camera on the floor, without the prefix; only `method: floor` needs it.",
        read_only=True,
    )  # fmt: skip
    wait_s: float = param(
        0.15, "How long what is seen at one moment waits for the rest of it.", unit="s", gt=0.0
    )
    input_timeout_s: float = param(
        1.0,
        "Silence of the bearings, and of views put together of them, allowed.",
        unit="s",
        gt=0.0,
    )
    publish_tf: bool = param(False, "Send map->odom, unless somebody else does.", read_only=True)

    def __post_init__(self) -> None:
        validate(self)
