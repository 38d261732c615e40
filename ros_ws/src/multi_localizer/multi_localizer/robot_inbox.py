"""What came from one robot, by stamp, and what of it tells of one moment.

Bearings taken a little before or after the moment are turned by the robot's own odometry, if there
is one; what its way does to them besides is `team_corrections`'. Values are kept by the robot's own
stamps and read by our clock, so that all that is known of its clock counts for each of them; once
its clock turns out to be another, all of it is forgotten. Stamps and times in ns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.clock_offsets import TeammateClock
from multi_localizer.odometry_track import pose_at
from multi_localizer.pose_estimate import PoseEstimate, moved, propagate
from multi_localizer.stamped_values import Arrival, StampedValues
from multi_localizer.team_node_config import TeamTimingConfig
from multi_localizer.team_views import RobotView

V = TypeVar("V")

ROBOTS = "robots"
"""Class of the bearings to teammates."""
_AHEAD_NS = 1_000_000_000
_LEAST_MOTION_SD = 1e-3


@dataclass(frozen=True)
class Classes:
    """What the classes of bearings besides `robots` are of."""

    landmarks: frozenset[str] = frozenset()
    objects: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class Sight:
    """What one robot tells of a moment.

    Attributes:
        view: Its bearings as if taken at the moment, but for its way since; `rough` of its camera.
        stamp_ns: When its bearings were taken.
    """

    view: RobotView
    stamp_ns: int


@dataclass
class RobotInbox:
    """Messages of one robot.

    Attributes:
        name: Its namespace.
        config: Which messages belong together.
        classes: What its bearings may be of.
        mount: Its camera in its base_link; None until known.
        mount_problem: What to say while it is not.
        problem: Why nothing of it is to be used, in words; "" for none.
        clock: Its clock against ours.
        counts: Of messages by what became of them.
        heard_ns: When its last bearings came, on the clock that silence is counted on.
    """

    name: str
    config: TeamTimingConfig
    classes: Classes = Classes()
    mount: SE2 | None = None
    mount_problem: str = "where its camera sits is not known"
    problem: str = ""
    clock: TeammateClock = field(default_factory=TeammateClock)
    counts: Counter[str] = field(default_factory=Counter)
    heard_ns: int | None = None
    _bearings: dict[str, StampedValues[np.ndarray]] = field(default_factory=dict)
    _poses: StampedValues[PoseEstimate] = field(default_factory=StampedValues)
    _odometry: StampedValues[SE2] = field(default_factory=StampedValues)
    _corrected_ns: int = 0  # by what the values were read last

    @property
    def newest_ns(self) -> int | None:
        """Stamp of its newest bearings to robots, by our clock."""
        return self._own_ns(self._of(ROBOTS).newest_ns)

    @property
    def complete_ns(self) -> int | None:
        """Stamp up to which bearings of all classes have come that it sends at present."""
        newest_ns = self.newest_ns
        if newest_ns is None:
            return None
        old_ns = newest_ns - round(self.config.robot_timeout_s * 1e9)
        others = [self._own_ns(values.newest_ns) for values in self._bearings.values()]
        return min(ns for ns in others if ns is not None and ns > old_ns)

    def take_bearings(self, kind: str, stamp_ns: int, bearings: np.ndarray, now_ns: int) -> bool:
        """Take bearings of a class, shape (M,); return whether they are new."""
        self.counts["void bearings"] += int(np.count_nonzero(~np.isfinite(bearings)))
        return self._take(self._of(kind), stamp_ns, bearings[np.isfinite(bearings)], now_ns)

    def take_pose(self, stamp_ns: int, estimate: PoseEstimate, now_ns: int) -> bool:
        """Take where the robot believes to be by itself."""
        return self._take(self._poses, stamp_ns, estimate, now_ns)

    def take_odometry(self, stamp_ns: int, pose: SE2, now_ns: int) -> bool:
        """Take a pose in its odometry's frame."""
        return self._take(self._odometry, stamp_ns, pose, now_ns)

    def motion(self, from_ns: int, to_ns: int) -> SE2 | None:
        """Return its base at one stamp seen from that at another; None where no odometry tells."""
        if from_ns == to_ns:
            return SE2.identity()
        start, end = self._odometry_at(from_ns), self._odometry_at(to_ns)
        return None if start is None or end is None else start.between(end)

    def camera_motion(self, from_ns: int, to_ns: int) -> SE2 | None:
        """Return its camera at one stamp seen from that at another; None where not known."""
        motion = self.motion(from_ns, to_ns)
        if motion is None or self.mount is None:
            return None
        return self.mount.inverse() @ motion @ self.mount

    def carried_base(self, estimate: PoseEstimate, from_ns: int, to_ns: int) -> PoseEstimate | None:
        """Return a pose of its base brought to another stamp; None where that is too far off."""
        apart_s = abs(to_ns - from_ns) / 1e9
        if apart_s > self.config.pose_max_age_s:
            return None
        return propagate(estimate, *self._step(self.motion(from_ns, to_ns), apart_s))

    def sight_at(self, stamp_ns: int) -> Sight | str:
        """Return what it tells of a moment, or why nothing."""
        if self.mount is None:
            return self.problem or self.mount_problem
        if self.problem:
            return self.problem
        found = self._nearest(self._of(ROBOTS), stamp_ns)
        if found is None:
            return "no bearings"
        taken_ns, bearings = found
        turn = self._turn_since(taken_ns, stamp_ns)
        if turn is None:
            side = "after" if taken_ns > stamp_ns else "before"
            return f"its nearest bearings were taken {abs(taken_ns - stamp_ns) / 1e9:.2f} s {side}"
        view = RobotView(
            name=self.name,
            bearings=_turned(bearings, turn),
            landmark_bearings=self._others(self.classes.landmarks, taken_ns, stamp_ns),
            object_bearings=self._others(self.classes.objects, taken_ns, stamp_ns),
            rough=self._rough(stamp_ns),
        )
        return Sight(view, taken_ns)

    def clear(self) -> None:
        """Forget all that has a stamp: our clock jumped."""
        self._drop_values()
        self.clock.restart()
        self._corrected_ns = 0
        self.heard_ns = None

    def _of(self, kind: str) -> StampedValues[np.ndarray]:
        return self._bearings.setdefault(kind, StampedValues())

    def _take(self, values: StampedValues[V], stamp_ns: int, value: V, now_ns: int) -> bool:
        correction_ns = self._correction_ns()
        if stamp_ns <= 0 or stamp_ns - correction_ns > now_ns + _AHEAD_NS:
            self.counts["unstamped" if stamp_ns <= 0 else "ahead"] += 1
            return False
        if abs(correction_ns - self._corrected_ns) > self.config.max_skew_s * 1e9:
            self._drop_values()
        self._corrected_ns = correction_ns
        arrival = values.add(stamp_ns, value)
        if arrival is Arrival.ANEW:  # then all else that it sent is of the time before, too
            self._drop_values()
            values.add(stamp_ns, value)
        self.counts[arrival.value] += 1
        return arrival in (Arrival.NEW, Arrival.LATE, Arrival.ANEW)

    def _drop_values(self) -> None:
        for values in self._bearings.values():
            values.clear()
        self._poses.clear()
        self._odometry.clear()

    def _own_ns(self, stamp_ns: int | None) -> int | None:
        """Return one of its stamps by our clock."""
        return None if stamp_ns is None else stamp_ns - self._corrected_ns

    def _nearest(self, values: StampedValues[V], stamp_ns: int) -> tuple[int, V] | None:
        """Return the value nearest to a stamp, and its own stamp, both by our clock."""
        found = values.nearest(stamp_ns + self._corrected_ns)
        return None if found is None else (found[0] - self._corrected_ns, found[1])

    def _correction_ns(self) -> int:
        offset = self.clock.offset
        if not self.config.correct_clocks or offset is None or offset.error_ns is None:
            return 0
        return offset.offset_ns if abs(offset.offset_ns) > offset.error_ns else 0

    def _turn_since(self, taken_ns: int, stamp_ns: int) -> float | None:
        """Return how far it turned since bearings were taken; None where they are too far off."""
        apart_s = abs(stamp_ns - taken_ns) / 1e9
        motion = self.motion(taken_ns, stamp_ns)
        if motion is not None and apart_s <= max(self.config.carry_s, self.config.max_skew_s):
            return motion.yaw
        return 0.0 if apart_s <= self.config.max_skew_s else None

    def _others(
        self, kinds: frozenset[str], taken_ns: int, stamp_ns: int
    ) -> Mapping[str, np.ndarray]:
        """Return bearings of other classes, taken together with those to robots."""
        found: dict[str, np.ndarray] = {}
        for kind in sorted(kinds & self._bearings.keys()):
            nearest = self._nearest(self._of(kind), taken_ns)
            turn = None if nearest is None else self._turn_since(nearest[0], stamp_ns)
            if nearest is not None and turn is not None:
                found[kind] = _turned(nearest[1], turn)
        return found

    def _rough(self, stamp_ns: int) -> PoseEstimate | None:
        """Return where its camera is by its own localization, brought to a moment."""
        nearest = self._nearest(self._poses, stamp_ns)
        if nearest is None or self.mount is None:
            return None
        pose_ns, estimate = nearest
        base = self.carried_base(estimate, pose_ns, stamp_ns)
        return None if base is None else moved(base, self.mount)

    def _step(self, motion: SE2 | None, apart_s: float) -> tuple[SE2, np.ndarray]:
        """Return a motion with its covariance; none known: it stood still, more or less."""
        if motion is None:
            sd = np.full(3, self.config.unknown_speed_m_s * apart_s)
            return SE2.identity(), np.diag(np.maximum(sd, _LEAST_MOTION_SD) ** 2)
        size = np.array([motion.distance, motion.distance, abs(motion.yaw)])
        sd = np.maximum(self.config.odometry_error * size, _LEAST_MOTION_SD)
        return motion, np.diag(sd**2)

    def _odometry_at(self, stamp_ns: int) -> SE2 | None:
        """Return its pose by odometry; in gaps of it only for as long as bearings are carried."""
        skew_s = self.config.max_skew_s
        gap_ns = 1e9 * max(self.config.carry_s, skew_s)
        return pose_at(self._odometry, stamp_ns + self._corrected_ns, gap_ns, 1e9 * skew_s)


def _turned(bearings: np.ndarray, turn: float) -> np.ndarray:
    """Return bearings as seen after a turn of the robot, in (-pi, pi]."""
    return np.array([wrap_angle(b - turn) for b in bearings])
