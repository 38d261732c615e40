"""Pose from the border of the floor region: any plan, obstacles, sub-pixel, with covariance.

Beyond the floor paper's section 4: every piece of border that is seen is a measurement, not only
the hull's corners, each with its own noise in both directions of the image; a piece belongs to the
wall that its bearing meets first, so that hidden corners mislead nobody; what lies nearer than the
walls is an obstacle's and does not count; the border as a whole may lie some part of a pixel inside
or outside (pixels that are part wall), and every wall a little by itself. Without a guess that
leads to a good fit the whole plan is searched (the published start, moments of the region, needs a
region seen whole); few pieces of border are fitted from the likeliest places, all from the best.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_coarse import fit_starts
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_doubts import PolishedFit, doubt
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_polish import polish, summary
from multi_localizer.floor_rays import BorderRays, BorderScanner
from multi_localizer.floor_search import PlanSearch, slides
from multi_localizer.floor_walls import walls_of
from multi_localizer.pose_estimate import PoseEstimate, difference, moved, placed

REACH = 1.02
MIN_PIECES = 24
MIN_BEHIND, BEHIND_PX = 4, 3.0
COARSE_PIECES = 160
MAX_FITS = 12
POLISH_STEPS = 8
FIRST_PX, FINE_PX = 36.0, 4.0
SURE_COST = 0.4  # of a fit that follows from the guess: it will do
CLEAR_COST = 0.15  # of any fit: below it what fits much worse is no rival
NEAR_COST = 0.05  # so much worse than a clear fit may only be how few pieces were looked at
ALIKE_CHI2 = 100.0  # of the whole border; neighbors err together
FOLLOWED = 0.3, 0.3  # m, rad: a fit so near the guess follows from it
NOWHERE, NONE = np.empty(0, dtype=np.int64), np.empty((0, 5))


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
        first_cost: The same of the best with all that lies behind walls, which is left out later.
    """

    candidates: tuple[PoseEstimate, ...]
    num_points: int
    residual_px: float
    hidden_share: float
    problem: str
    offset_px: float = 0.0
    costs: tuple[float, ...] = ()
    first_cost: float = 0.0


class _Polished(NamedTuple):
    """A fit of the whole border.

    Attributes:
        fit: With its one pose, or why there is none.
        behind: Paths on which there is floor behind the walls.
        apart_px: How far each piece lies from the walls, (N,).
        sd_px: Deviation of a piece.
    """

    fit: FloorFit
    behind: np.ndarray = NOWHERE
    apart_px: np.ndarray = NOWHERE
    sd_px: float = math.nan


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
        self.walls, self.search = walls_of(plan), PlanSearch(plan)
        self._symmetries = np.array([s.as_array() for s in plan.symmetries])
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
        border = self.scanner.scan(mask)
        found = self._found(border, guess)
        fit, behind = self._decided(border, found)
        if fit.problem or len(behind) < MIN_BEHIND:
            return fit
        border, first = self.scanner.scan(mask, behind), fit.costs[0]
        fit, _ = self._decided(border, self._fits(border, found[:, :3], FINE_PX))
        return replace(fit, first_cost=first)

    def fit_border(self, border: BorderRays, guess: PoseEstimate | None = None) -> FloorFit:
        """Return the poses that a border fits."""
        return self._decided(border, self._found(border, guess))[0]

    def _found(self, border: BorderRays, guess: PoseEstimate | None) -> np.ndarray:
        """Return different poses with offset and cost, (F, 5), the best first."""
        if len(border.values) < MIN_PIECES:
            return NONE
        found, is_followed = NONE, False
        if guess is not None:
            start = (guess.pose @ self._T_camera_base.inverse()).as_array()
            found = self._fits(border, start[None], FIRST_PX)
            is_followed = len(found) > 0 and _follows(found[0], start)
        if not is_followed or len(self.plan.symmetries) == 1:
            starts = self.search.starts(border.values)
            found = self._fits(border, starts, FIRST_PX, found)
        if len(found) and found[0, 4] >= SURE_COST:
            pose, offset = found[0, :3], float(found[0, 3])
            starts = slides(border.values, self.walls, pose, offset, self.plan.reach)
            found = self._fits(border, starts, FINE_PX, found)
        return found

    def _fits(
        self, border: BorderRays, starts: np.ndarray, first_px: float, found: np.ndarray = NONE
    ) -> np.ndarray:
        """Return the different fits from starts (S, 3), and those found before, the best first."""
        step = max(1, len(border.values) // COARSE_PIECES)
        some, starts = np.ascontiguousarray(border.values[::step]), np.ascontiguousarray(starts)
        fits = np.empty((MAX_FITS, 5))
        fits[: len(found)] = found
        num = fit_starts(some, starts, self.walls, self._symmetries, first_px, fits, len(found))
        return fits[:num]

    def _decided(self, border: BorderRays, found: np.ndarray) -> tuple[FloorFit, np.ndarray]:
        """Return the fit, and the paths on which there is floor behind the walls."""
        if len(border.values) < MIN_PIECES:
            few = f"only {len(border.values)} pixels of the floor's border are seen"
            return _none(few), NOWHERE
        if not len(found):
            return _none("the border fits no pose on the plan"), NOWHERE
        is_clear = found[0, 4] < CLEAR_COST
        near = found[0, 4] + NEAR_COST
        worst = near if is_clear else max(near, 1.0 - self.config.rival * (1.0 - found[0, 4]))
        rivals = found[found[:, 4] <= worst]
        fits = [self._polished(border, rival) for rival in rivals]
        if fits[0].fit.problem:
            return fits[0].fit, fits[0].behind
        good = [(f, r[4]) for f, r in zip(fits, rivals, strict=True) if not f.fit.problem]
        if is_clear and len(good) > 1:
            good = self._alike(good)
        best = good[0][0]
        turns = self.plan.symmetries[1:]  # the first is none
        mates = [(mate, cost) for f, cost in good for mate in _mates(f.fit.candidates[0], turns)]
        candidates, costs = zip(*mates, strict=True)
        costs = tuple(map(float, costs))
        return replace(best.fit, candidates=candidates, costs=costs), best.behind

    def _alike(self, fits: list[tuple[_Polished, float]]) -> list[tuple[_Polished, float]]:
        """Return those that the whole border fits nearly as well as the best, the best first."""
        sd, gate = max(f.sd_px for f, _ in fits), self.config.gate_sd
        chi2 = [float((np.minimum(f.apart_px / sd, gate) ** 2).sum()) for f, _ in fits]
        order = np.argsort(chi2, kind="stable")
        return [fits[k] for k in order if chi2[k] - chi2[order[0]] < ALIKE_CHI2]

    def _polished(self, border: BorderRays, start: np.ndarray) -> _Polished:
        """Return the fit of all of the border, or what speaks against it."""
        state, cov, sd, is_settled, weights, rows = polish(
            border.values, border.moves, start[:3], start[3], self.walls, self._limits,
            POLISH_STEPS,
        )  # fmt: skip
        offset = float(state[3])
        num, square, beyond = summary(rows, weights, offset, self.config.gate_sd * sd)
        hidden, rms = 1.0 - num / border.num_paths, math.sqrt(square)
        if not is_settled:
            return _Polished(_none("the fit of the border comes to no rest", num, hidden))
        if num < MIN_PIECES or not np.isfinite(cov).all() or not np.isfinite(state).all():
            return _Polished(_none("the border fits no pose on the plan", num, hidden))
        found = PolishedFit(state[:3], cov, sd, offset, hidden, beyond)
        problem = doubt(found, self.plan, self.config)
        if problem:
            return _Polished(_none(problem, num, hidden, rms))
        estimate = PoseEstimate(SE2(*state[:3].tolist()), cov)
        if self._T_camera_base.distance > 0.0:
            estimate = moved(estimate, self._T_camera_base)
        off = rows[:, 0] - offset
        apart = np.where(rows[:, 4] >= 0, np.abs(off), np.inf)
        fit = FloorFit((estimate,), num, rms, hidden, "", offset)
        return _Polished(fit, border.index[off < -BEHIND_PX], apart, float(sd))


def _follows(found: np.ndarray, guess: np.ndarray) -> bool:
    """Return whether a fit (5,) is good and near a guess (3,)."""
    x, y, yaw = difference(SE2(*found[:3].tolist()), SE2(*guess.tolist()))
    is_near = math.hypot(x, y) < FOLLOWED[0] and abs(yaw) < FOLLOWED[1]
    return bool(is_near and found[4] < SURE_COST)


def _mates(estimate: PoseEstimate, turns: Sequence[SE2]) -> list[PoseEstimate]:
    return [estimate, *(placed(turn, estimate) for turn in turns)]


def _none(problem: str, num: int = 0, hidden: float = 1.0, rms: float = math.nan) -> FloorFit:
    return FloorFit((), num, rms, hidden, problem)
