"""Every value of the node stereo_localizer besides the method; defaults stand here alone."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param
from multi_localizer.stereo_pairs_config import StereoPairsConfig


@dataclass(frozen=True, kw_only=True)
class StereoLocalizerNodeConfig(StereoPairsConfig):
    """The node `stereo_localizer`."""

    map_file: str = param(
        "", "Voxel map, made by make_voxel_map (npz); it has no default.", read_only=True
    )
    use_odom: bool = param(
        True, "Follow the motion by odom -> base; without it by the views alone.",
        read_only=True,
    )  # fmt: skip
    pairs_wait_s: float = param(
        2.0, "How long the first pair waits for the others to appear, before it goes on alone.",
        unit="s", ge=0.0, read_only=True,
    )  # fmt: skip
    publish_tf: bool = param(
        False, "Send map->odom, unless somebody else does; needs use_odom.", read_only=True
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.publish_tf and not self.use_odom:
            raise ValueError("publish_tf needs use_odom: without odometry there is no map->odom")
