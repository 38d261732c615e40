"""What every recording is turned into: scans and ranges, each with the poses it needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2


class RecordingError(Exception):
    """A recording that cannot be used as asked; the message is one line for the user."""


@dataclass(frozen=True)
class ScanEvent:
    """One laser scan, ready to be mapped.

    Attributes:
        stamp_ns: Time of the first beam, ns.
        scan: The scan in the laser's own frame.
        T_base_laser: Pose of the laser on the robot.
        T_odom_base: Odometry at the stamp; None where the user said that there is none.
        follows_jump: True for the first scan after the stamps jumped back (a looped bag).
    """

    stamp_ns: int
    scan: Scan
    T_base_laser: SE2
    T_odom_base: SE2 | None
    follows_jump: bool = False


@dataclass(frozen=True)
class RangeEvent:
    """One reading of a range sensor such as a sonar.

    Attributes:
        stamp_ns: Time of the reading, ns.
        frame: Frame of the sensor; tells sonars of one topic apart.
        range: As the driver sent it, m; `sonar_reading.classify` says what it means.
        range_min: Shortest distance that is a measurement, m.
        range_max: Longest distance that is a measurement, m.
        fov: Opening angle of the cone, rad.
        T_base_sonar: Pose of the sensor on the robot.
        T_odom_base: Odometry at the stamp; None where there is none.
    """

    stamp_ns: int
    frame: str
    range: float
    range_min: float
    range_max: float
    fov: float
    T_base_sonar: SE2
    T_odom_base: SE2 | None

    @property
    def reading(self) -> RangeReading:
        """The reading by itself."""
        return RangeReading(self.range, self.fov, self.range_min, self.range_max)


Event = ScanEvent | RangeEvent


@dataclass(frozen=True, kw_only=True)
class WheelOptions:
    """Wheels of a robot whose log has only encoder ticks; the defaults are the Mines rover's.

    Attributes:
        ticks_per_turn: Encoder ticks of one full wheel turn.
        wheel_radius_m: m.
        half_axle_m: From the middle of the axle to a wheel, m.
    """

    ticks_per_turn: float = 2000.0
    wheel_radius_m: float = 0.077
    half_axle_m: float = 0.165

    def __post_init__(self) -> None:
        """Refuse what no wheel has."""
        for name in ("ticks_per_turn", "wheel_radius_m", "half_axle_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")


@dataclass(frozen=True, kw_only=True)
class RecordingOptions:
    """What the user says about a recording; None leaves it to the recording itself.

    Attributes:
        scan_topic: LaserScan topic of a bag.
        odom_topic: Odometry topic of a bag.
        sonar_topics: Range topics of a bag; empty reads none.
        sonar_poses: Frames of sonars with their poses on the robot; beat the recording.
        laser_pose: Pose of the laser on the robot; beats the recording.
        use_odom: False where odometry shall not be read.
        base_frame: Frame of the robot in a bag; None for base_link, or what the bag has instead.
        odom_frame: Frame of the odometry in a bag; None for odom, or what the bag has instead.
        range_limits_m: Shortest and longest range that is a measurement; beats the recording.
        use_recorded_stamps: True to take the times of recording instead of a bag's stamps.
        wheels: Geometry for logs of wheel ticks.
    """

    scan_topic: str | None = None
    odom_topic: str | None = None
    sonar_topics: tuple[str, ...] = ()
    sonar_poses: tuple[tuple[str, SE2], ...] = ()
    laser_pose: SE2 | None = None
    use_odom: bool = True
    base_frame: str | None = None
    odom_frame: str | None = None
    range_limits_m: tuple[float, float] | None = None
    use_recorded_stamps: bool = False
    wheels: WheelOptions = WheelOptions()

    def __post_init__(self) -> None:
        """Refuse limits that leave no range."""
        if self.range_limits_m is not None:
            low, high = self.range_limits_m
            if not 0.0 <= low < high:
                raise ValueError(f"range limits must be 0 <= MIN < MAX, got {low:g} {high:g}")


@dataclass
class Counts:
    """What was met while a recording was read; grows as its events are taken.

    Attributes:
        scans: Scans in the recording.
        without_transform: Scans (or ranges) left out: odometry never covers their stamp.
        stamps_backwards: Scans stamped before the scan that was recorded before them.
        stamps_repeated: Scans with the stamp of the scan before them.
        jumps: Times the whole recording jumped back in time.
        malformed: Lines or messages that could not be read or used.
        unplaced: Scans left out: the robot was not yet found in the session gone on with.
        infrared: Frames of infrared rangers, which see through glass: left out.
    """

    scans: int = 0
    without_transform: int = 0
    stamps_backwards: int = 0
    stamps_repeated: int = 0
    jumps: int = 0
    malformed: int = 0
    unplaced: int = 0
    infrared: set[str] = field(default_factory=set)


@dataclass
class Recording:
    """An open recording.

    Attributes:
        format: Name of the format, such as `CARMEN log`.
        info: Lines for the user: which topics, frames and odometry are used, and why.
        num_scans: Scans to expect, for progress; None where not known beforehand, 0 where there is
            no laser: then `T_odom_base` of the ranges is all that says where the robot is.
        counts: Filled while the events are taken.
        problem: Why reading stopped early; None if the recording is whole.
    """

    format: str
    info: list[str]
    source: EventSource
    num_scans: int | None = None
    counts: Counts = field(default_factory=Counts)
    problem: str | None = None

    @property
    def has_laser(self) -> bool:
        """Whether there are scans by which the robot is localized."""
        return self.num_scans != 0

    def events(self) -> Iterator[Event]:
        """Yield the events in lockstep order; take them once."""
        return self.source(self)


class EventSource(Protocol):
    """Yields a recording's events and notes counts and problems in it on the way."""

    def __call__(self, recording: Recording) -> Iterator[Event]:
        """Yield the events of the recording."""
        ...
