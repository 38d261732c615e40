"""What the node `team_localizer` is told beside the solver's own values."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class TeamNodeConfig:
    """Who is in the team, and what its robots are to tell."""

    team: tuple[str, ...] = param(
        (), "Namespaces of all robots, such as [r1, r2, r3]; their order is that of `team/poses`.",
        read_only=True,
    )  # fmt: skip
    publish_for: str = param(
        "own", "Whose pose to publish: that of the robot whose namespace this node is in, or of "
        "all (`/<namespace>/team_pose` each).", choices=("own", "all"), read_only=True,
    )  # fmt: skip
    pose_topic: str = param(
        "pose", "Where each robot's own localization is, below its namespace.", read_only=True
    )
    landmarks: str = param(
        "", "File of landmarks, or the name of one in the package; empty for none.", read_only=True
    )
    poses_use_landmarks: bool = param(
        True, "The robots' own poses were made from these same bearings of landmarks: then they "
        "begin the search, but are not counted twice.",
    )  # fmt: skip
    over_time: bool = param(
        True, "Join the moments by the robots' `odom`, where they have one; otherwise each pose "
        "rests on one moment alone.",
    )  # fmt: skip
    repeat_s: float = param(
        6.0, "With `over_time`: errors of bearings to one thing are alike for about so long; 0 "
        "takes every bearing for new knowledge.", unit="s", ge=0.0, le=3600.0,
    )  # fmt: skip
    object_classes: tuple[str, ...] = param(
        (), "Classes of other things to locate: `bearings/<class>` of each robot.", read_only=True
    )
    publish_tf: bool = param(
        False, "Send map->odom from this robot's pose in the team.", read_only=True
    )

    def __post_init__(self) -> None:
        """Refuse values outside their ranges and teams that cannot be."""
        validate(self)
        object.__setattr__(self, "team", tuple(clean_namespace(name) for name in self.team))
        doubled = sorted({name for name in self.team if self.team.count(name) > 1})
        if doubled:
            raise ValueError(f"team must name each robot once, got {doubled[0]!r} twice")


@dataclass(frozen=True, kw_only=True)
class TeamTimingConfig:
    """Which messages belong together."""

    max_skew_s: float = param(
        0.1, "Bearings of two robots belong together if taken within this time.",
        unit="s", gt=0.0, le=10.0,
    )  # fmt: skip
    carry_s: float = param(
        0.5, "Older or newer bearings are carried by the robot's `odom`, where it has one, over at "
        "most this time.", unit="s", ge=0.0, le=10.0,
    )  # fmt: skip
    wait_s: float = param(
        0.15, "How long bearings wait for those that teammates take later.",
        unit="s", ge=0.0, le=10.0,
    )  # fmt: skip
    robot_timeout_s: float = param(
        2.0, "A robot silent for longer is taken to be away, and not waited for.",
        unit="s", gt=0.0, le=3600.0,
    )  # fmt: skip
    pose_max_age_s: float = param(
        1.0, "A robot's own pose may be this much older than its bearings.",
        unit="s", ge=0.0, le=60.0,
    )  # fmt: skip
    correct_clocks: bool = param(
        True, "Take the measured offset out of a teammate's stamps; otherwise it is only said."
    )
    odometry_error: float = param(
        0.1, "Deviation of carried motion, as a share of it.", ge=0.0, le=1.0
    )
    unknown_speed_m_s: float = param(
        0.3, "How fast a robot without odometry may have moved since its own pose, deviation; "
        "it may have turned by as many rad/s.", unit="m/s", ge=0.0, le=10.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse values outside their ranges."""
        validate(self)


def clean_namespace(name: str) -> str:
    """Return a namespace without slashes around it.

    Raises:
        ValueError: If nothing or something that is no ROS name is left.
    """
    clean = name.strip("/")
    parts = clean.split("/")
    if not all(part.isascii() and part.isidentifier() for part in parts):
        raise ValueError(f"team must hold namespaces such as r1, got {name!r}")
    return clean
