"""What is kept of scans and readings, so that maps can be made anew at better poses.

Poses are those of the front end, with the node of the graph that was the newest then.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.bayes_config import BayesConfig
from grid_mapper.config import KeyScanConfig
from grid_mapper.key_scans import KeyScans

APART_M, APART_RAD = 0.02, 0.03
"""Readings of a sonar nearer to each other than this are of one place."""


@dataclass(frozen=True)
class KeptScan:
    """A scan.

    Attributes:
        number: Of the event; they count up.
        stamp_ns: Of the scan.
        scan: In the laser's frame.
        T_base_laser: Pose of the laser on the robot.
        T_local_base: Pose of the robot by the front end.
        node: The newest node; this scan's own where it is one.
        is_node: Whether it is.
        information: Of the match, see `ScanResult`; None without one.
        follows_jump: Whether the robot was found again there, not driven from the last node.
    """

    number: int
    stamp_ns: int
    scan: Scan
    T_base_laser: SE2
    T_local_base: SE2
    node: int
    is_node: bool
    information: np.ndarray | None
    follows_jump: bool = False


@dataclass(frozen=True)
class KeptReading:
    """A sonar's reading; as `KeptScan`, with the sonar's pose on the robot and its name."""

    number: int
    stamp_ns: int
    reading: RangeReading
    T_base_sonar: SE2
    T_local_base: SE2
    node: int
    sensor: str


Kept = KeptScan | KeptReading


class ReadingsToKeep:
    """Picks readings: no more of one place, and saying the same, than glass is found by."""

    def __init__(self, config: BayesConfig) -> None:
        self._most = round(config.max_repeats)
        self._key = KeyScanConfig(distance_m=APART_M, turn_rad=APART_RAD, period_s=0.0)
        self._places: dict[str, KeyScans] = {}
        self._said: dict[str, tuple[float, int]] = {}

    def take(self, stamp_ns: int, reading: RangeReading, pose: SE2, sensor: str) -> bool:
        """Tell whether to keep a reading taken at a pose of the robot."""
        is_new = self._places.setdefault(sensor, KeyScans()).take(stamp_ns, pose, self._key)
        said, num = self._said.get(sensor, (np.nan, 0))
        is_same = reading.range == said or abs(reading.range - said) < 0.05
        if is_new or not is_same:
            num = 0
        elif num >= self._most:
            return False
        self._said[sensor] = (reading.range, num + 1)
        return True
