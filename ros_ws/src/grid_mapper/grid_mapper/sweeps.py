"""Scans taken beam by beam while the robot moves: in which order, and all seen from one place.

By its definition a LaserScan has the stamp of its first beam, and the others follow it at
`time_increment`; the motion of the last two scans then says where each was taken from (`twists`).
Drivers do not keep to that: one that turns the beams of a clockwise sensor round sends the last
first, with the stamp of the end, and others send a constant. So the order is learned: while the
robot turns, a scan is fitted to the map with its beams in either order. With the difference d of
how well the two fit,

    z = sum(d) / sqrt(sum(d^2))                                                              (1)

is beyond t by chance with a probability below 2 exp(-t^2 / 2), if both are as likely (Efron 1969).
That is of one look. It is looked after each scan, of at most 300: by simulation z leaves +-4 at any
of them in 0.1 % of drives with d = +-1, and in 0.05 % with normal d (400 000 drives each).
Until one order is that sure the beams are taken to be of one moment, as they are where a sweep
takes longer than scans are apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from statistics import median

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.twists import Twist, twist_between, twist_of_mounted
from grid_mapper.config import MotionConfig

AS_SENT, TURNED_ROUND, UNKNOWN = 1, -1, 0
ORDERS = {"first_to_last": AS_SENT, "last_to_first": TURNED_ROUND}
WORDS = {AS_SENT: "first to last", TURNED_ROUND: "last to first"}
NUM_GAPS, GAP_SLACK = 10, 1.05
MAX_GAP_S = 1.0
"""Over a longer time the motion says little of that of a sweep."""
MIN_TURN_RAD = 0.01
"""A sweep in which the robot turns less does not tell the orders apart."""
SURE, MAX_TRIALS = 4.0, 300


class SweepOrder:
    """Learns in which order the beams of a laser follow each other.

    Attributes:
        order: `AS_SENT`, `TURNED_ROUND` or `UNKNOWN`.
        objection: Why the times of the beams are not believed; "" while they are.
        num_trials: Scans that were fitted in both orders.
    """

    def __init__(self) -> None:
        self.order, self.objection, self.num_trials = UNKNOWN, "", 0
        self._last_ns: int | None = None
        self._gaps: list[float] = []
        self._sum = self._sum_squares = 0.0

    def note(self, stamp_ns: int, scan: Scan) -> None:
        """Take the stamp of a scan, and judge its times once it is clear how often scans come."""
        if scan.time_increment == 0.0 or self.objection or self.is_believed:
            return
        if not 0.0 < scan.time_increment < math.inf:
            self.objection = f"time_increment is {scan.time_increment:g}"
            return
        if self._last_ns is not None and stamp_ns > self._last_ns:
            self._gaps.append((stamp_ns - self._last_ns) * 1e-9)
        self._last_ns = stamp_ns
        if self.is_believed and scan.sweep_s > GAP_SLACK * median(self._gaps):
            self.objection = (
                f"by time_increment a sweep takes {scan.sweep_s:.3f} s, but scans are "
                f"{median(self._gaps):.3f} s apart"
            )

    @property
    def is_believed(self) -> bool:
        """Whether the times of the beams are."""
        return not self.objection and len(self._gaps) >= NUM_GAPS

    def deskewed(self, scan: Scan, T_base_laser: SE2, twist: Twist | None, deskew: str) -> Scan:
        """Return a scan with its motion, if the order of its beams is known.

        Args:
            scan: With `time_increment` 0 it is returned as it is.
            T_base_laser: Pose of the laser on the robot.
            twist: Of the robot; None where it is not known.
            deskew: See `GridMapperConfig`.
        """
        order = self.order if deskew == "auto" else ORDERS.get(deskew, UNKNOWN)
        if scan.time_increment == 0.0 or twist is None or order == UNKNOWN or not self.is_believed:
            return scan
        return in_order(scan, T_base_laser, twist, order)

    def learn(
        self, scan: Scan, T_base_laser: SE2, twist: Twist | None, fit: Callable[[Scan], float]
    ) -> None:
        """Learn from one scan, if there is anything to learn.

        Args:
            scan: As it came.
            T_base_laser: Pose of the laser on the robot.
            twist: Of the robot; None where it is not known.
            fit: Tells how well a scan fits the map, 0..1.
        """
        is_open = self.order == UNKNOWN and self.is_believed and self.num_trials < MAX_TRIALS
        if not is_open or twist is None or abs(twist[2]) * scan.sweep_s < MIN_TURN_RAD:
            return
        sent, turned = (
            fit(in_order(scan, T_base_laser, twist, order)) for order in (AS_SENT, TURNED_ROUND)
        )
        self.num_trials += 1
        self._sum += sent - turned
        self._sum_squares += (sent - turned) ** 2
        z = self._sum / math.sqrt(self._sum_squares) if self._sum_squares > 0.0 else 0.0  # eq. 1
        if abs(z) >= SURE:
            self.order = AS_SENT if z > 0.0 else TURNED_ROUND

    def words(self, deskew: str) -> str:
        """Return what is known of the order; "" where all beams are of one moment as sent."""
        if self.objection:
            return f"taken as of one moment: {self.objection}"
        if self._last_ns is None:
            return ""
        if deskew == "auto" and self.order != UNKNOWN:
            return f"{WORDS[self.order]}, learned from {self.num_trials} scans in turns"
        if deskew == "auto":
            return f"taken as of one moment: the order is open after {self.num_trials} in turns"
        order = ORDERS.get(deskew, UNKNOWN)
        return f"{WORDS.get(order, 'taken as of one moment')}, as `deskew` says"


def in_order(scan: Scan, T_base_laser: SE2, twist: Twist, order: int) -> Scan:
    """Return a scan with the motion of its sensor; the stamp is that of the beam sent first.

    Args:
        scan: As it came, with a time between beams > 0.
        T_base_laser: Pose of the laser on the robot.
        twist: Of the robot.
        order: `AS_SENT` or `TURNED_ROUND`, for which beams go back in time.
    """
    step = order * scan.time_increment
    return replace(scan, time_increment=step, twist=twist_of_mounted(twist, T_base_laser))


Sweep = tuple[float, Twist]
"""Time between beams, < 0 where they go back in time, and twist of the sensor."""


def sweep_of(scan: Scan) -> Sweep | None:
    """Return the motion that a scan has been given; None if it has none."""
    return None if scan.twist is None else (scan.time_increment, scan.twist)


def with_sweep(scan: Scan, sweep: Sweep | None) -> Scan:
    """Return a scan with the motion that it had before."""
    return scan if sweep is None else replace(scan, time_increment=sweep[0], twist=sweep[1])


def sweep_twist(moved: SE2, dt: float, motion: MotionConfig) -> Twist | None:
    """Return the twist of the robot by its motion of late; None where that says nothing.

    Args:
        moved: Motion since the last scan.
        dt: Time since then, s.
        motion: What is too fast to be a motion.
    """
    if not 0.0 < dt <= MAX_GAP_S:
        return None
    twist = twist_between(moved, dt)
    is_fast = math.hypot(*twist[:2]) > motion.max_speed or abs(twist[2]) > motion.max_turn_rate
    return None if is_fast else twist
