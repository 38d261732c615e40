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
from grid_mapper.motion import odometry_motion, rotated, steady_motion, updated_velocity
from grid_mapper.scan_matcher import MatchResult, ScanMatcher, offset
from grid_mapper.surface_points import SurfacePoints, surface_points

# How far a pose given by hand, or kept over a jump in time, can be off: (m, m, rad).
VAGUE_SIGMAS = np.array([0.3, 0.3, 0.2])
MIN_VARIANCE = 1e-8


@dataclass(frozen=True)
class ScanResult:
    """What became of a scan.

    Attributes:
        T_map_base: Pose of the robot at the scan's stamp.
        cov: Of (x, y, yaw) in map axes, shape (3, 3), SI.
        is_trusted: False where the match was refused and the pose is the prediction.
        reason: Why it was refused; "" if trusted.
        overlap: Share of the scan's points that found the map, 0..1; 1 for the first scan.
    """

    T_map_base: SE2
    cov: np.ndarray
    is_trusted: bool
    reason: str
    overlap: float


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

    def __init__(self, config: GridMapperConfig, T_map_start: SE2 | None = None) -> None:
        """Start knowing nothing; `T_map_start` is the first pose, the map's origin by default."""
        self.config = config
        self._T_map_start = T_map_start or SE2.identity()
        self._matcher = ScanMatcher(config.matcher)
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
        points = self._points(scan, T_base_laser)
        T_pred, cov_moved, dt = self._predict(stamp_ns, T_odom_base)
        cov, cov_near = (
            (cov_moved, cov_moved)
            if self._last is None
            else (self._last.cov + cov_moved, self._last.cov_near + cov_moved)
        )
        if self._matcher.is_empty:
            result = self._first(len(points), T_pred, cov)
        else:
            match = self._matcher.match(points, T_pred, cov_near)
            result = self._judge(match, len(points), T_pred, cov, cov_near)
        pose = result.T_map_base
        if result.is_trusted and self._keys.take(stamp_ns, pose, self.config.match_key):
            self._matcher.insert(points, pose)
        self._remember(stamp_ns, T_odom_base, result, cov_near, dt)
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
        if self._last is None:
            self._T_map_start = T_map_base
        else:
            self._last = _Step(self._last.stamp_ns, T_map_base, None, cov, cov, np.zeros(3))

    def break_motion(self) -> None:
        """Forget the motion so far: time or odometry jumped. The map and the pose stay."""
        if self._last is not None:
            self.relocate(self._last.T_map_base)

    @property
    def num_bytes(self) -> int:
        """Bytes held by the map to match to."""
        return self._matcher.num_bytes

    def _points(self, scan: Scan, T_base_laser: SE2) -> SurfacePoints:
        matcher = self.config.matcher
        points_laser = scan.points()
        points = surface_points(
            points_laser, np.zeros(2), scan.angle_increment, matcher.range_sigma_m,
            0.5 * matcher.cell_m,
        )  # fmt: skip
        return points.moved(T_base_laser)

    def _predict(self, stamp_ns: int, T_odom_base: SE2 | None) -> tuple[SE2, np.ndarray, float]:
        """Return the predicted pose, the covariance of the motion in map axes, the time passed."""
        last = self._last
        if last is None:
            return self._T_map_start, np.zeros((3, 3)), 0.0
        dt = max(0.0, (stamp_ns - last.stamp_ns) * 1e-9)
        if T_odom_base is not None and last.T_odom_base is not None:
            moved = last.T_odom_base.between(T_odom_base)
            cov = odometry_motion(moved, self.config.motion)
        else:
            moved, cov = steady_motion(last.velocity, dt, self.config.motion)
        return last.T_map_base @ moved, rotated(cov, last.T_map_base.yaw), dt

    def _first(self, num_points: int, T_pred: SE2, cov: np.ndarray) -> ScanResult:
        if num_points < self.config.min_pairs:
            reason = f"only {num_points} points in the first scan"
            return ScanResult(T_pred, cov, False, reason, 0.0)
        return ScanResult(T_pred, cov, True, "", 1.0)

    def _judge(
        self,
        match: MatchResult,
        num_points: int,
        T_pred: SE2,
        cov_pred: np.ndarray,
        cov_near: np.ndarray,
    ) -> ScanResult:
        """Believe a match, or say why not and keep the prediction."""
        off = offset(T_pred, match.T_map_base)
        sigmas = float(np.sqrt(off @ np.linalg.solve(cov_near, off)))
        config, reason = self.config, ""
        if match.num_pairs < config.min_pairs or match.overlap < config.min_overlap:
            reason = f"{match.num_pairs} of {num_points} points found the map"
        elif match.agreement < config.min_agreement:
            reason = f"the points that found the map agree with it by {match.agreement:.2f}"
        elif match.overlap < config.sure_overlap and sigmas > config.max_correction_sigmas:
            reason = f"a match of few points is {sigmas:.1f} deviations from the prediction"
        if reason:
            return ScanResult(T_pred, cov_pred, False, reason, match.overlap)
        cov = np.linalg.inv(np.linalg.inv(cov_pred) + match.information)
        return ScanResult(match.T_map_base, cov, True, "", match.overlap)

    def _remember(
        self,
        stamp_ns: int,
        T_odom_base: SE2 | None,
        result: ScanResult,
        cov_near: np.ndarray,
        dt: float,
    ) -> None:
        last = self._last
        velocity = np.zeros(3)
        if last is not None:
            moved = last.T_map_base.between(result.T_map_base)
            velocity = updated_velocity(last.velocity, moved, dt, self.config.motion)
        near = np.zeros((3, 3)) if result.is_trusted else cov_near
        self._last = _Step(stamp_ns, result.T_map_base, T_odom_base, result.cov, near, velocity)
