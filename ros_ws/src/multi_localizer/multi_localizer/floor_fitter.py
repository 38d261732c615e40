"""Pose from the border of the floor region: any plan, obstacles, sub-pixel, with covariance.

Beyond the floor paper's section 4: every piece of border that is seen is a measurement, not only
the hull's corners, each with its own noise in both directions of the image; a piece belongs to the
wall that its bearing meets first, so that hidden corners mislead nobody; what lies nearer than the
walls is an obstacle's and does not count; the border as a whole may lie some part of a pixel inside
or outside (pixels that are part wall), and every wall a little by itself. The published steps 1 to
5 say where to begin; if that leads nowhere the whole plan is searched.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_doubts import PolishedFit, doubt
from multi_localizer.floor_kernels import anneal
from multi_localizer.floor_moments import polygon_moments
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_polish import polish
from multi_localizer.floor_rays import BorderRays, BorderScanner
from multi_localizer.floor_search import places_of, search, slides
from multi_localizer.pose_estimate import PoseEstimate, difference, moved, placed

REACH = 1.02
MIN_PIECES = 24
MIN_BEHIND, BEHIND_PX = 4, 3.0
COARSE_PIECES = 160
COARSE_STEPS, POLISH_STEPS = 20, 8
FIRST_PX, FINE_PX, SPREAD_PX = 36.0, 4.0, 1.0
SURE_COST = 0.4  # of a fit that follows from the guess: it will do
CLEAR_COST = 0.15  # of any fit: below it nothing else can fit nearly as well
FOLLOWED = 0.3, 0.3  # m, rad: a fit so near the guess follows from it
SAME = 0.1, 0.1  # m, rad: fits so near each other are one
NOWHERE = np.empty(0, dtype=np.int64)
_TURNS = (0.0, 0.5, -0.5)  # of a quarter


@dataclass(frozen=True, eq=False)
class FloorFit:
    """What a mask says about the robot's pose.

    Attributes:
        candidates: Poses of base_link that fit, the best first; those that a symmetry of the plan
            makes of each other follow each other. Empty if there is a problem.
        num_points: Pieces of border that belong to walls.
        residual_px: Root mean square of their residuals.
        hidden_share: Of all directions, those that show no wall.
        problem: Why there is no pose; "" if there is one.
        offset_px: How far inside the walls the border lies.
        costs: Of each candidate, the share of the border that does not fit it; floor behind walls
            costs more.
    """

    candidates: tuple[PoseEstimate, ...]
    num_points: int
    residual_px: float
    hidden_share: float
    problem: str
    offset_px: float = 0.0
    costs: tuple[float, ...] = ()


class FloorShapeFitter:
    """Finds poses for the masks of one camera on one floor.

    Args:
        camera: The camera that the masks come from, at their size.
        plan: The floor.
        config: How the border is fitted.
        scanner: What finds the border; None: made when first needed.
    """

    def __init__(
        self,
        camera: FloorCamera,
        plan: FloorPlan,
        config: FloorFitConfig | None = None,
        scanner: BorderScanner | None = None,
    ) -> None:
        if scanner is not None:
            self.scanner = scanner
        self.camera, self.plan = camera, plan
        self.config = FloorFitConfig() if config is None else config
        self.walls = np.column_stack(
            (plan.corners, plan.tangents, plan.normals, plan.offsets, plan.lengths)
        )
        self._places, self._model = places_of(plan), polygon_moments(plan.corners)
        c = self.config
        self._limits = (
            c.border_sd_px, c.max_sd_px, c.gate_sd, c.offset_sd_px, c.wall_sd_px, c.coarse_m
        )  # fmt: skip
        self._T_camera_base = SE2(*camera.position_m, 0.0).inverse()

    @cached_property
    def scanner(self) -> BorderScanner:
        """What finds the border in masks; made when first needed."""
        return BorderScanner(self.camera, REACH * self.plan.reach)

    def fit(self, mask: np.ndarray, guess: PoseEstimate | None = None) -> FloorFit:
        """Return the poses that a mask fits.

        Args:
            mask: Not 0 where the floor is, (H, W), uint8.
            guess: Where base_link may be; the fit begins there too.

        Raises:
            ValueError: The mask is not of the camera's size.
        """
        fit, behind = self._fit(self.scanner.scan(mask), guess)
        if fit.problem or len(behind) < MIN_BEHIND:
            return fit
        return self._fit(self.scanner.scan(mask, behind), fit.candidates[0])[0]

    def fit_border(self, border: BorderRays, guess: PoseEstimate | None = None) -> FloorFit:
        """Return the poses that a border fits."""
        return self._fit(border, guess)[0]

    def _fit(self, border: BorderRays, guess: PoseEstimate | None) -> tuple[FloorFit, np.ndarray]:
        """Return the fit, and the paths on which there is floor behind the walls."""
        if len(border.values) < MIN_PIECES:
            return _none(
                f"only {len(border.values)} pixels of the floor's border are seen"
            ), NOWHERE
        found = self._coarse(border, guess)
        fits = [(*self._polished(border, start, offset), cost) for start, offset, cost in found
                if 1.0 - cost >= self.config.rival * (1.0 - found[0][2])]  # fmt: skip
        if not fits:
            return _none("the border fits no pose on the plan"), NOWHERE
        best, behind, _ = fits[0]
        if best.problem:
            return best, behind
        good = [(f.candidates[0], cost) for f, _, cost in fits if not f.problem]
        mates = [[placed(s, candidate) for s in self.plan.symmetries] for candidate, _ in good]
        costs = [cost for m, (_, cost) in zip(mates, good, strict=True) for _ in m]
        candidates = tuple(c for m in mates for c in m)
        return replace(best, candidates=candidates, costs=tuple(costs)), behind

    def _coarse(
        self, border: BorderRays, guess: PoseEstimate | None
    ) -> list[tuple[np.ndarray, float, float]]:
        """Return poses, offsets and costs of the different fits found, the best first."""
        step = max(1, len(border.values) // COARSE_PIECES)
        found: list[tuple[np.ndarray, float, float]] = []
        is_even, is_followed = len(self.plan.symmetries) > 1, False
        for k, start in enumerate(self._starts(border, guess)):
            self._add(found, border, step, start)
            if k == 0 and guess is not None and found:
                is_near = _is_near(SE2(*found[0][0]), SE2(*start), FOLLOWED)
                is_followed = is_near and found[0][2] < SURE_COST
            if found and is_even and (is_followed or found[0][2] < CLEAR_COST):
                break
        if not found or (found[0][2] >= CLEAR_COST and not is_followed):
            for start in search(border.values, self.walls, self._places):
                self._add(found, border, step, start)
        if found and found[0][2] >= SURE_COST:
            pose, offset, _ = found[0]
            for start in slides(border.values, self.walls, pose, offset, self.plan.reach):
                self._add(found, border, step, start, FINE_PX)
        return found

    def _add(
        self,
        found: list[tuple[np.ndarray, float, float]],
        border: BorderRays,
        step: int,
        start: np.ndarray,
        first_px: float = FIRST_PX,
    ) -> None:
        """Fit from a start and keep what is new."""
        pose, offset, cost = anneal(
            border.values, step, start, self.walls, first_px, SPREAD_PX, COARSE_STEPS
        )
        if not np.isfinite(pose).all():
            return
        here = SE2(*pose)
        for k, (other, _, old) in enumerate(found):
            if any(_is_near(s @ here, SE2(*other), SAME) for s in self.plan.symmetries):
                if cost >= old:
                    return
                del found[k]
                break
        found.append((pose, float(offset), float(cost)))
        found.sort(key=lambda f: f[2])

    def _starts(self, border: BorderRays, guess: PoseEstimate | None) -> list[np.ndarray]:
        """Return where fits begin: the guess, and what the region's moments say (step 5)."""
        starts = []
        if guess is not None:
            T_base_camera = self._T_camera_base.inverse()
            starts.append((guess.pose @ T_base_camera).as_array())
        points = border.values[:, :2] / border.values[:, 2:3]
        hull = cv2.convexHull(points.astype(np.float32))[:, 0].astype(float)
        try:
            region, model = polygon_moments(hull), self._model
        except ValueError:
            return starts
        is_even = len(self.plan.symmetries) > 1
        quarters = (0, 1) if is_even else (0, 2, 1, 3)
        for quarter in quarters:
            for turn in _TURNS:
                yaw = model.axis_rad - region.axis_rad + 0.5 * math.pi * (quarter + turn)
                x, y = model.center - (SE2(0.0, 0.0, yaw) @ region.center[None])[0]
                starts.append(np.array((x, y, yaw)))
        return starts

    def _polished(
        self, border: BorderRays, start: np.ndarray, offset: float
    ) -> tuple[FloorFit, np.ndarray]:
        """Return the fit of all of the border, what speaks against it, and what is behind walls."""
        pose, cov, offset, sd, is_settled, weights, rows = polish(
            border.values, border.moves, start, offset, self.walls, self._limits, POLISH_STEPS
        )
        is_wall = weights > 0.0
        num = int(is_wall.sum())
        hidden = 1.0 - num / border.num_paths
        if not is_settled:
            return _none("the fit of the border comes to no rest", num, hidden), NOWHERE
        if num < MIN_PIECES or not np.isfinite(cov).all() or not np.isfinite(pose).all():
            return _none("the border fits no pose on the plan", num, hidden), NOWHERE
        off = rows[:, 0] - offset
        rms = float(np.sqrt(np.mean(off[is_wall] ** 2)))
        beyond = float(np.mean((rows[:, 4] >= 0) & (off < -self.config.gate_sd * sd)))
        found = PolishedFit(pose, cov, sd, float(offset), hidden, beyond)
        problem = doubt(found, self.plan, self.config)
        if problem:
            return _none(problem, num, hidden, rms), NOWHERE
        estimate = PoseEstimate(SE2(*pose), cov)
        if self._T_camera_base.distance > 0.0:
            estimate = moved(estimate, self._T_camera_base)
        behind = border.index[off < -BEHIND_PX]
        return FloorFit((estimate,), num, rms, hidden, "", float(offset)), behind


def _is_near(a: SE2, b: SE2, within: tuple[float, float]) -> bool:
    x, y, yaw = difference(a, b)
    return math.hypot(x, y) < within[0] and abs(wrap_angle(yaw)) < within[1]


def _none(problem: str, num: int = 0, hidden: float = 1.0, rms: float = math.nan) -> FloorFit:
    return FloorFit((), num, rms, hidden, problem)
