"""Where the robot is: dead reckoning, then scan-to-map ICP (glass paper, section 3).

Every scan is predicted from odometry (or from steady motion), fitted to the map of surface cells,
and judged; key scans are added to that map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.key_scans import KeyScans
from grid_mapper.match_verdict import ScanResult, blind, is_found, objection, undetermined
from grid_mapper.motion import odometry_motion, rotated, steady_motion, updated_velocity
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.surface_points import SurfacePoints, points_of

# How far a pose given by hand, or kept over a jump in time, can be off: (m, m, rad).
VAGUE_SIGMAS = np.array([0.3, 0.3, 0.2])
MIN_VARIANCE = 1e-8
RESET_SLACK_S = 0.5  # logs stamp scans that badly
LOST = "where in the map the robot is is not known"


@dataclass(frozen=True)
class _Step:
    """State after a scan, from which the next is predicted.

    `cov` is that of the pose in the map; `cov_near` counts only what came since the last trusted
    scan, for the map round the robot was made by poses that share all error before that.
    """

    stamp_ns: int
    T_map_base: SE2
    T_odom_base: SE2 | None
    cov: np.ndarray
    cov_near: np.ndarray
    velocity: np.ndarray


class ScanLocalizer:
    """Turns scans into poses in the map that they make."""

    def __init__(
        self, config: GridMapperConfig, T_map_start: SE2 | None = None,
        matcher: ScanMatcher | None = None, is_frozen: bool = False,
    ) -> None:  # fmt: skip
        """Start knowing nothing.

        Args:
            config: Its values.
            T_map_start: The first pose, the map's origin by default.
            matcher: Holds the map to match to; by default one of all key scans.
            is_frozen: Whether that map is to stay as it is.
        """
        self.config = config
        self._T_map_start = T_map_start or SE2.identity()
        self._matcher = matcher or ScanMatcher(config.matcher)
        self._is_frozen = is_frozen
        self._start_cov: np.ndarray | None = None
        self._is_lost = False
        self._first_pose: SE2 | None = None
        self._guesses: list[SE2] = []  # where the robot may be after a jump; empty if it knows
        self._last: _Step | None = None
        self._keys = KeyScans()

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those marked read-only stay as they were."""
        self.config = config
        self._matcher.config = config.matcher

    def localize(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> ScanResult:
        """Find the pose of one scan, and keep the scan if the robot has moved on.

        Args:
            stamp_ns: Of the scan.
            scan: In the laser's frame.
            T_base_laser: Pose of the laser on the robot.
            T_odom_base: Odometry at the stamp; None to expect steady motion instead.
        """
        points = points_of(scan, T_base_laser, self.config.matcher)
        if self._is_reset(stamp_ns, T_odom_base):
            self.break_motion()
        if self._last is None and not self._matcher.is_empty:
            self._begin_in_map(stamp_ns)
        moved, cov_moved, dt = self._motion(stamp_ns, T_odom_base)
        if self._is_lost:
            result, near = self._follow(moved, cov_moved), np.diag(VAGUE_SIGMAS**2)
        elif self._matcher.is_empty:
            result, near = self._first(len(points)), np.zeros((3, 3))
        elif self._guesses:
            result, near = self._search(points, moved), np.diag(VAGUE_SIGMAS**2)
        else:
            result, near = self._track(points, moved, cov_moved)
        pose = result.T_map_base
        if result.is_trusted:
            near = np.zeros((3, 3))
            if self._keys.take(stamp_ns, pose, self.config.match_key) and not self._is_frozen:
                self._matcher.insert(points, pose)
        self._remember(stamp_ns, T_odom_base, result, near, dt)
        return result

    def relocate(self, T_map_base: SE2, cov: np.ndarray | None = None) -> None:
        """Go on from another pose, as told from outside; the next scan settles it.

        Args:
            T_map_base: About where the robot is.
            cov: Of (x, y, yaw) in map axes, shape (3, 3); None, or one that claims to know a
                coordinate exactly, stands for 0.3 m and 0.2 rad.
        """
        if cov is None or np.linalg.eigvalsh(cov).min() < MIN_VARIANCE:
            cov = np.diag(VAGUE_SIGMAS**2)
        self._guesses, self._is_lost = [], False
        if self._last is None:
            self._T_map_start, self._start_cov = T_map_base, cov
        else:
            self._last = _Step(self._last.stamp_ns, T_map_base, None, cov, cov, np.zeros(3))

    def lose(self) -> None:
        """Follow odometry alone, and believe no scan until `relocate`: the robot is anywhere."""
        self._is_lost, self._guesses = True, []

    def break_motion(self, T_map_first: SE2 | None = None) -> None:
        """Go on after time or odometry jumped: the map stays, the robot may be anywhere.

        It counts as found again where a scan fits the map well near the newest pose or near the
        first one (a recording that starts again), or where `relocate` says.

        Args:
            T_map_first: Where the first pose lies by now; by default where it was.
        """
        if self._last is None or self._first_pose is None:
            return
        T_last, first = self._last.T_map_base, T_map_first or self._first_pose
        self.relocate(T_last)
        self._guesses = [T_last, first]

    @property
    def num_bytes(self) -> int:
        """Bytes held by the map to match to."""
        return self._matcher.num_bytes

    def _is_reset(self, stamp_ns: int, T_odom_base: SE2 | None) -> bool:
        """Tell whether odometry jumped by more than a robot can move."""
        last = self._last
        if T_odom_base is None or last is None or last.T_odom_base is None:
            return False
        moved, motion = last.T_odom_base.between(T_odom_base), self.config.motion
        dt = abs(stamp_ns - last.stamp_ns) * 1e-9 + RESET_SLACK_S
        return moved.distance > motion.max_speed * dt or abs(moved.yaw) > motion.max_turn_rate * dt

    def _motion(self, stamp_ns: int, T_odom_base: SE2 | None) -> tuple[SE2, np.ndarray, float]:
        """Return the motion since the last scan, its covariance in map axes, the time passed."""
        last = self._last
        if last is None:
            return SE2.identity(), np.zeros((3, 3)), 0.0
        dt = max(0.0, (stamp_ns - last.stamp_ns) * 1e-9)
        if T_odom_base is not None and last.T_odom_base is not None:
            moved = last.T_odom_base.between(T_odom_base)
            cov = odometry_motion(moved, self.config.motion)
        else:
            moved, cov = steady_motion(last.velocity, dt, self.config.motion)
        return moved, rotated(cov, last.T_map_base.yaw), dt

    def _begin_in_map(self, stamp_ns: int) -> None:
        """Begin where the robot was said to be in a map that is there."""
        cov = np.diag(VAGUE_SIGMAS**2) if self._start_cov is None else self._start_cov
        start = self._first_pose = self._T_map_start
        self._last = _Step(stamp_ns, start, None, cov, cov, np.zeros(3))

    def _follow(self, moved: SE2, cov_moved: np.ndarray) -> ScanResult:
        """Go on by odometry."""
        assert self._last is not None
        pose = self._last.T_map_base @ moved
        return ScanResult(pose, self._last.cov + cov_moved, False, LOST, 0.0)

    def _first(self, num_points: int) -> ScanResult:
        """Start the map, if the scan shows anything."""
        motion, pose = self.config.motion, self._T_map_start
        cov = np.diag([motion.base_m, motion.base_m, motion.base_rad]) ** 2
        cov = cov if self._start_cov is None else self._start_cov
        if num_points < self.config.min_pairs:
            reason = f"only {num_points} points in the first scan"
            return ScanResult(pose, cov, False, reason, 0.0)
        self._first_pose = pose
        return ScanResult(pose, cov, True, "", 1.0)

    def _track(
        self, points: SurfacePoints, moved: SE2, cov_moved: np.ndarray
    ) -> tuple[ScanResult, np.ndarray]:
        """Match near the prediction; return the verdict and the doubt since the last match."""
        last = self._last
        assert last is not None
        T_pred, near = last.T_map_base @ moved, last.cov_near + cov_moved
        match = self._matcher.match(points, T_pred, near)
        cov = last.cov + cov_moved
        reason = objection(match, len(points), T_pred, near, self.config)
        if last.T_odom_base is None:
            reason = reason or blind(match, cov, self.config)
        if reason:
            return ScanResult(T_pred, cov, False, reason, match.overlap), near
        cov = np.linalg.inv(np.linalg.inv(cov) + match.information)
        note = undetermined(match, self.config)
        pose, information = match.T_map_base, match.information
        return ScanResult(pose, cov, True, "", match.overlap, note, information), near

    def _search(self, points: SurfacePoints, moved: SE2) -> ScanResult:
        """Look for the robot where it may be; believe only a scan that fits the map well."""
        cov = np.diag(VAGUE_SIGMAS**2)
        self._guesses = [guess @ moved for guess in self._guesses]
        fits = [self._matcher.match(points, guess, cov) for guess in self._guesses]
        best = max(fits, key=lambda fit: fit.overlap * fit.agreement)
        if is_found(best, self.config):
            self._guesses = []
            cov = np.linalg.inv(np.linalg.inv(cov) + best.information)
            return ScanResult(best.T_map_base, cov, True, "", best.overlap, "", best.information)
        reason = f"time or odometry jumped, and {100 * best.overlap:.0f} % of the scan fits the map"
        return ScanResult(self._guesses[0], cov, False, reason, best.overlap)

    def _remember(
        self, stamp_ns: int, T_odom_base: SE2 | None, result: ScanResult, near: np.ndarray,
        dt: float,
    ) -> None:  # fmt: skip
        last = self._last
        velocity = np.zeros(3)
        if last is not None:
            moved = last.T_map_base.between(result.T_map_base)
            velocity = updated_velocity(last.velocity, moved, dt, self.config.motion)
        self._last = _Step(stamp_ns, result.T_map_base, T_odom_base, result.cov, near, velocity)
