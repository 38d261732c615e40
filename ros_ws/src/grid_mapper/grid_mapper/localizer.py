"""Where the robot is: dead reckoning, then scan-to-map ICP (glass paper, section 3).

Every scan is predicted from odometry (or from steady motion), fitted to the map of surface cells,
and judged; key scans are added to that map.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.after_jump import WAY_M, Guess, looked_at, settled
from grid_mapper.config import GridMapperConfig
from grid_mapper.dead_reckoning import Step, goes_on, is_reset, motion_since
from grid_mapper.key_scans import KeyScans
from grid_mapper.match_verdict import ScanResult, blind, first_verdict, objection, undetermined
from grid_mapper.motion import updated_velocity
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.surface_points import SurfacePoints, points_of
from grid_mapper.sweeps import SweepOrder, sweep_twist

VAGUE_COV = np.diag([0.3, 0.3, 0.2]) ** 2
"""How far a pose given by hand, or kept over a jump in time, can be off (m, m, rad)."""
MIN_VARIANCE = 1e-8
LOST = "where in the map the robot is is not known"


class ScanLocalizer:
    """Turns scans into poses in the map that they make.

    Attributes:
        sweeps: In which order the beams of a scan are taken.
    """

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
        self._guesses: list[Guess] = []  # where the robot may be after a jump; empty if it knows
        self._last: Step | None = None
        self._T_odom_before: SE2 | None = None  # odometry before a jump of time
        self._keys = KeyScans()
        self.sweeps = SweepOrder()

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those marked read-only stay as they were."""
        self.config = config
        self._matcher.config = config.matcher

    def deskewed(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> Scan:
        """Return a scan as all of it was seen from where the robot was at its stamp.

        Args: see `localize`, which takes what this returns.
        """
        if scan.time_increment == 0.0 or scan.twist is not None:
            return scan
        self.sweeps.note(stamp_ns, scan)
        motion = self.config.motion
        moved, _, dt = motion_since(self._last, stamp_ns, T_odom_base, motion)
        twist = sweep_twist(moved, dt, motion)
        return self.sweeps.deskewed(scan, T_base_laser, twist, self.config.deskew)

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
        motion = self.config.motion
        if is_reset(self._last, stamp_ns, T_odom_base, motion):
            self._guess_anew(0.0)
        elif T_odom_base is not None:
            self._go_on(T_odom_base)
        if self._last is None and not self._matcher.is_empty:
            self.begin_in_map(stamp_ns)
        moved, cov_moved, dt = motion_since(self._last, stamp_ns, T_odom_base, motion)
        if self._is_lost:
            result, near = self._follow(moved, cov_moved), VAGUE_COV
        elif self._matcher.is_empty:
            result, near = self._first(len(points)), np.zeros((3, 3))
        elif self._guesses:
            result, near = self._search(points, moved, T_odom_base is not None), VAGUE_COV
        else:
            result, near = self._track(points, moved, cov_moved)
        pose = result.T_map_base
        if result.is_trusted:
            if scan.time_increment > 0.0 and scan.twist is None:
                self._learn_order(scan, T_base_laser, moved, near, dt)
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
            cov = VAGUE_COV
        self._guesses, self._is_lost, self._T_odom_before = [], False, None
        if self._last is None:
            self._T_map_start, self._start_cov = T_map_base, cov
        else:
            self._last = Step(self._last.stamp_ns, T_map_base, None, cov, cov, np.zeros(3))

    def lose(self) -> None:
        """Follow odometry alone, and believe no scan until `relocate`: the robot is anywhere."""
        self._is_lost, self._guesses = True, []

    def break_motion(self, T_map_first: SE2 | None = None) -> None:
        """Go on after time or odometry jumped: the map stays, the robot may be anywhere.

        It counts as found again where scans go on to fit the map well near the newest pose or near
        the first one (a recording that starts again), or where `relocate` says; only there after
        `lose`. Where odometry goes on as it was, one scan that fits near the newest pose is enough.

        Args:
            T_map_first: Where the first pose lies by now; by default where it was.
        """
        last, before = self._last, self._T_odom_before
        self._guess_anew(WAY_M, T_map_first)
        self._T_odom_before = before if last is None else last.T_odom_base or before

    @property
    def num_bytes(self) -> int:
        """Bytes held by the map to match to."""
        return self._matcher.num_bytes

    def _guess_anew(self, way_m: float, T_map_first: SE2 | None = None) -> None:
        """Guess where the robot is; near the newest pose it is believed after a way of `way_m`."""
        if self._last is None or self._first_pose is None:
            return
        T_last, was_lost = self._last.T_map_base, self._is_lost
        self.relocate(T_last)
        self._is_lost = was_lost
        if not was_lost:
            self._guesses = [Guess(T_last, way_m), Guess(T_map_first or self._first_pose)]

    def _go_on(self, T_odom_base: SE2) -> None:
        """Follow odometry over a jump of time, if it did not jump too."""
        before, self._T_odom_before = self._T_odom_before, None
        if before is None or self._last is None or not goes_on(before, T_odom_base):
            return
        self._last = replace(self._last, T_odom_base=before)
        if self._guesses:
            self._guesses[0] = replace(self._guesses[0], way_m=0.0)

    def begin_in_map(self, stamp_ns: int) -> None:
        """Begin where the robot was said to be in a map that is there."""
        cov = VAGUE_COV if self._start_cov is None else self._start_cov
        start = self._first_pose = self._T_map_start
        self._last = Step(stamp_ns, start, None, cov, cov, np.zeros(3))

    def _follow(self, moved: SE2, cov_moved: np.ndarray) -> ScanResult:
        """Go on by odometry."""
        assert self._last is not None
        pose = self._last.T_map_base @ moved
        return ScanResult(pose, self._last.cov + cov_moved, False, LOST, 0.0)

    def _first(self, num_points: int) -> ScanResult:
        """Start the map, if the scan shows anything."""
        result = first_verdict(num_points, self._T_map_start, self._start_cov, self.config)
        if result.is_trusted:
            self._first_pose = result.T_map_base
        return result

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

    def _learn_order(
        self, scan: Scan, T_base_laser: SE2, moved: SE2, near: np.ndarray, dt: float
    ) -> None:
        """Learn the order of the beams from how either fits at the prediction."""
        if self._last is None or self.config.deskew != "auto":
            return
        T_pred = self._last.T_map_base @ moved

        def fit(swept: Scan) -> float:
            points = points_of(swept, T_base_laser, self.config.matcher)
            match = self._matcher.match(points, T_pred, near)
            return match.overlap * match.agreement

        twist = sweep_twist(moved, dt, self.config.motion)
        self.sweeps.learn(scan, T_base_laser, twist, fit)

    def _search(self, points: SurfacePoints, moved: SE2, has_odom: bool) -> ScanResult:
        """Look for the robot where it may be; believe only a place that scans go on to fit."""
        cov, guesses = VAGUE_COV, self._guesses
        fits = [self._matcher.match(points, guess.pose @ moved, cov) for guess in guesses]
        looks = zip(guesses, fits, strict=True)
        self._guesses = [looked_at(*look, moved, has_odom, self.config) for look in looks]
        k = settled(self._guesses)
        if k is not None:
            self._guesses, fit = [], fits[k]
            cov = np.linalg.inv(np.linalg.inv(cov) + fit.information)
            return ScanResult(fit.T_map_base, cov, True, "", fit.overlap, "", fit.information)
        overlap = max(fit.overlap for fit in fits)
        reason = f"time or odometry jumped, and {100 * overlap:.0f} % of the scan fits the map"
        return ScanResult(self._guesses[0].pose, cov, False, reason, overlap)

    def _remember(
        self, stamp_ns: int, T_odom_base: SE2 | None, result: ScanResult, near: np.ndarray,
        dt: float,
    ) -> None:  # fmt: skip
        last = self._last
        velocity = np.zeros(3)
        if last is not None:
            moved = last.T_map_base.between(result.T_map_base)
            velocity = updated_velocity(last.velocity, moved, dt, self.config.motion)
        self._last = Step(stamp_ns, result.T_map_base, T_odom_base, result.cov, near, velocity)
