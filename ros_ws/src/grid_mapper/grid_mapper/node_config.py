"""What can be set of the mapping node beside the mapper."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class GridMapperNodeConfig:
    """What the node adds to the mapper."""

    pose_source: str = param(
        "icp",
        "icp: find the pose by scan matching and publish map->odom; tf: take map->base_link from "
        "another localizer (AMCL, slam_toolbox) and add only the layers.",
        choices=("icp", "tf"), read_only=True,
    )  # fmt: skip
    publish_tf: bool = param(True, "Publish map->odom while nobody else does.", read_only=True)
    use_odom: bool = param(
        True, "Start each match from odometry; false expects steady motion.", read_only=True
    )
    use_scan: bool = param(
        True, "False for a robot of sonars alone, which needs pose_source tf.", read_only=True
    )
    sonar_topics: tuple[str, ...] = param(
        ("sonar",),
        "Topics of ultrasonic sonars (Range): one for all, told apart by frame_id, or one each.",
        read_only=True,
    )
    reference_map: str = param(
        "",
        "Topic of a latched OccupancyGrid whose origin, size and resolution map/glass takes; empty "
        "for the mapper's own.",
        read_only=True,
    )
    max_pose_jump_m: float = param(
        0.3,
        "With pose_source tf: a pose that left odometry by more within a second is said, and "
        "nothing is mapped until it goes on steadily.",
        unit="m", gt=0.0,
    )  # fmt: skip
    max_pose_jump_rad: float = param(0.3, "The same for a turn.", unit="rad", gt=0.0)
    map_period_s: float = param(
        1.0, "The map is published at most this often.", unit="s", gt=0.0, read_only=True
    )
    map_file: str = param("", "Where ~/save_map writes, without ending; empty for a new name.")
    start_map: str = param(
        "",
        "Map to begin with (YAML of map_server); the robot is looked for near initialpose or "
        "anywhere. Empty for a map of its own.",
        read_only=True,
    )
    keep_start_map: bool = param(
        False, "Only localize in start_map: nothing is written into it.", read_only=True
    )
    session_file: str = param(
        "",
        "Where ~/save_map and the end of the node save the session too, whose graph start_session "
        "goes on with; one that is there is replaced. Empty saves none.",
        read_only=True,
    )
    start_session: str = param(
        "",
        "Session to go on with, of session_file or map_bag --save-session; the robot is looked for "
        "near its last and its first pose. Empty to begin anew.",
        read_only=True,
    )
    map_mode: str = param(
        "trinary", "What ~/save_map keeps of a cell.", choices=("trinary", "scale", "raw")
    )
    scan_timeout_s: float = param(2.0, "Silence after which the scan is missed.", unit="s", gt=0.0)
    lost_after_s: float = param(
        3.0, "The robot is lost when no scan was trusted for this long.", unit="s", gt=0.0
    )

    def __post_init__(self) -> None:
        validate(self)
        if not self.use_scan and self.pose_source == "icp":
            raise ValueError(
                "use_scan false needs pose_source tf: without scans nothing here finds the pose"
            )
        if self.keep_start_map and not self.start_map:
            raise ValueError("keep_start_map needs a start_map")
        if self.start_map and self.pose_source != "icp":
            raise ValueError("start_map needs pose_source icp: else poses come from TF")
        for name in ("session_file", "start_session"):
            if getattr(self, name) and (self.pose_source != "icp" or self.start_map):
                raise ValueError(f"{name} needs pose_source icp and no start_map")
        if len(set(self.sonar_topics)) != len(self.sonar_topics):
            raise ValueError(f"sonar_topics must differ, got {list(self.sonar_topics)}")
