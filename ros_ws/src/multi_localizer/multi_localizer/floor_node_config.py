"""Every value of the floor localizer besides the fit; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.motion_config import MotionConfig


@dataclass(frozen=True, kw_only=True)
class FloorTrackConfig(MotionConfig):
    """Which of the poses that fit is the robot's, over time."""

    settle_share: float = param(
        0.98, "A pose is given when it alone has this share of the belief.", gt=0.5, lt=1.0
    )
    settle_masks: int = param(
        3, "A pose is given when so many masks, one after the other, have shown it.", ge=1, le=100
    )
    least_share: float = param(
        0.002, "What is against poses leaves them this share together, so that they can come back.",
        gt=0.0, lt=0.1,
    )  # fmt: skip
    goal_sd_rad: float = param(
        0.2, "Deviation of a goal's bearing from that of the place in the plan.", unit="rad",
        gt=0.0, le=1.5,
    )  # fmt: skip
    false_goal_share: float = param(
        0.1, "Share of goals seen that are something else.", gt=0.0, lt=1.0
    )
    goal_weight: float = param(
        0.5, "How much of a goal's evidence counts each time: what is false lasts for some images.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    new_after_s: float = param(
        0.1, "What is seen sooner again counts for less, in proportion: it is the same evidence.",
        unit="s", gt=0.0, le=10.0,
    )  # fmt: skip
    fit_weight: float = param(
        8.0, "How much it speaks against a pose that less of the border fits it, each time.", ge=0.0
    )
    alike_share: float = param(
        0.05, "Poses fit alike if the border that fits them differs by no more than this share.",
        ge=0.0, lt=1.0,
    )  # fmt: skip
    worst_fit: float = param(
        0.3, "A mask leaves a pose that fits badly, or not at all, so much of its belief.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    carried_per_s: float = param(
        0.03, "How often it is moved by hand while no mask shows its pose: the belief evens out.",
        unit="1/s", ge=0.0,
    )  # fmt: skip
    max_skew_s: float = param(
        0.06, "A goal counts for the pose of a mask that is not farther off in time.", unit="s",
        ge=0.0, le=1.0,
    )  # fmt: skip
    lost_after_s: float = param(
        0.3, "Poses that do not follow from the motion are believed after this: carried away.",
        unit="s", ge=0.0, le=10.0,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class FloorLocalizerConfig:
    """The node `floor_localizer`."""

    plan: str = param(
        "small_size_field", "YAML of the floor's plan, or the name of one of the package.",
        read_only=True,
    )  # fmt: skip
    camera_model: str = param(
        "soccer_small_size", "YAML of the camera, or the name of one brought along.",
        read_only=True,
    )  # fmt: skip
    floor_frame: str = param(
        "omni_camera_floor", "Frame below the camera on the floor, without the prefix.",
        read_only=True,
    )  # fmt: skip
    use_odom: bool = param(
        True, "Follow the motion by odom -> base; without it by greatest speeds.", read_only=True
    )
    mask_timeout_s: float = param(1.0, "Silence of the masks allowed.", unit="s", gt=0.0)
    publish_tf: bool = param(
        False, "Send map->odom, unless somebody else does; needs use_odom.", read_only=True
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.publish_tf and not self.use_odom:
            raise ValueError("publish_tf needs use_odom: without odometry there is no map->odom")


@dataclass(frozen=True, kw_only=True)
class FloorPoseConfig:
    """The pose from the floor's shape: from each mask, and over time."""

    fit: FloorFitConfig = FloorFitConfig()
    track: FloorTrackConfig = FloorTrackConfig()

    def __post_init__(self) -> None:
        validate(self)
