"""Moments that contradict the track of a robot: one may be a bad image, some in a row are not.

Each is carried along by odometry and held against the next. Once enough of them say the same, the
track is wrong; one that agrees with the track makes all before it count for nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis, propagate

_CONTRADICTION = 40.0  # chi-squared of 3 degrees: once in 10^8
_ENOUGH = 3
_WAY_SHARE, _LEAST_SD = 0.2, 1e-3


@dataclass
class Contradictions:
    """What the moments before said of robots whose tracks they contradict, and how many did."""

    _said: dict[str, tuple[PoseEstimate, int]] = field(default_factory=dict)

    def find(
        self, now: Mapping[str, PoseEstimate], tracks: Mapping[str, PoseEstimate]
    ) -> dict[str, bool]:
        """Return the robots whose tracks this moment contradicts, and of each if that is enough.

        Args:
            now: Poses by this moment alone.
            tracks: Poses by all before.
        """
        found = {}
        for name in now.keys() & tracks.keys():
            if mahalanobis(tracks[name], now[name]) < _CONTRADICTION:
                self.forget(name)
                continue
            before, count = self._said.get(name, (now[name], 0))
            same = mahalanobis(before, now[name]) < _CONTRADICTION
            count = count + 1 if same else 1
            found[name] = count >= _ENOUGH
            self._said[name] = now[name], count
            if found[name]:
                self.forget(name)
        return found

    def move(self, name: str, way: SE2) -> None:
        """Carry along what was said of a robot."""
        if name in self._said:
            said, count = self._said[name]
            sd = _WAY_SHARE * np.array([way.distance, way.distance, abs(way.yaw)]) + _LEAST_SD
            self._said[name] = propagate(said, way, np.diag(sd**2)), count

    def forget(self, name: str) -> None:
        """Begin anew with a robot."""
        self._said.pop(name, None)
