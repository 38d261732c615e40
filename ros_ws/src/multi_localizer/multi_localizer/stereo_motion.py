"""What is known of the motion between two views, and how much of a view that motion makes new.

Both depend on the way and the time alone, not on how many views they are cut into: errors of
odometry are taken to stay the same for a short way and a short time, and to have nothing to do with
each other beyond. A view is new by the way from the last place that was looked at anew, not by the
way that wheels turned: who stands, or goes to and fro, sees nothing new.
"""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig

_ALIKE_M, _ALIKE_RAD, _ALIKE_S = 0.04, 0.04, 0.1
"""So far, and so long, the error of odometry stays the same."""
_TURN_BY_WAY = 0.1  # 1/m, the error of yaw on a straight way, of that of the way
_LEAST = 1e-10


def motion_covariance(motion: SE2 | None, dt: float, config: StereoLocalizerConfig) -> np.ndarray:
    """Return the covariance of a motion's x, y, yaw, (3, 3).

    Args:
        motion: By odometry; None without, when the robot may go anywhere at its highest speed.
        dt: Its time, s.
        config: Errors and speeds.
    """
    c = config
    if motion is None:
        way, turn = (c.free_speed_m_s * dt) ** 2, (c.free_turn_rad_s * dt) ** 2
        return np.diag([way + _LEAST, way + _LEAST, turn + _LEAST])
    going = _grown(motion.distance, _ALIKE_M)
    turning = _grown(abs(motion.yaw), _ALIKE_RAD)
    while_at_it = _grown(dt, _ALIKE_S)
    share = c.odometry_error**2
    way = share * going + c.drift_m_s**2 * while_at_it + _LEAST
    turn = share * (turning + _TURN_BY_WAY**2 * going) + c.drift_rad_s**2 * while_at_it + _LEAST
    return np.diag([way, way, turn])


def _grown(size: float, alike: float) -> float:
    """Return the variance, of 1 per `alike`, that grows with the size."""
    return size * max(size, alike)


class NewView:
    """Tells how much of each view is new, so that a way of `new_view_m` makes one new view.

    Args:
        config: Way and turn after which a view is as good as new.
    """

    def __init__(self, config: StereoLocalizerConfig) -> None:
        self.config = config
        self.begin()

    def begin(self) -> None:
        """Take the view of here as seen."""
        self._T_seen_here, self._counted = SE2.identity(), 0.0

    def share(self, motion: SE2) -> float:
        """Return how much of the view after a motion is new, 0 to 1."""
        return max(0.0, self._way(self._T_seen_here @ motion) - self._counted)

    def look(self, new: float, motion: SE2) -> None:
        """Count a view of which so much was new, after the motion that it showed."""
        self._counted += new
        self._T_seen_here = self._T_seen_here @ motion
        if self._counted >= 1.0:
            self.begin()

    def pass_by(self, motion: SE2) -> None:
        """Go on without a view."""
        self._T_seen_here = self._T_seen_here @ motion

    def _way(self, T: SE2) -> float:
        c = self.config
        return min(1.0, T.distance / c.new_view_m + abs(T.yaw) / c.new_view_rad)
