"""The unified camera model from views of a flat board (Mei and Rives 2007), by least squares.

Intrinsics and the pose of every board are refined together, with exact derivatives. Where the
corners of a board begin, and whether the picture is seen in a mirror, plays no part: a flat board
of a regular pattern seen in a mirror is a board in another pose. So boards cannot tell where the
camera looks; `looks` of the camera file says that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import f as fisher_f

from floor_perception.board_pose import board_pose
from floor_perception.board_view import INTRINSICS, BoardView, view_jacobian, view_pixels
from floor_perception.fit_statistics import FitStatistics, fit_statistics
from floornav_common.cameras.sphere import lift
from floornav_common.cameras.unified import UnifiedCamera

MODELS = {
    "round": ("xi", "f", "center_u_px", "center_v_px"),
    "radial": ("xi", "f", "center_u_px", "center_v_px", "k1", "k2"),
    "full": tuple(name for name in INTRINSICS if name != "skew_px"),
    "skewed": INTRINSICS,
}
"""What each model leaves free; `f` is both focal lengths."""
AUTO = "auto"
NESTED = ("round", "radial", "full")
CHANCE = 0.01
MIN_BOARDS = 3
START_SHARES = np.geomspace(0.08, 1.2, 14)
"""Focal lengths to start from, as shares of the image's longer side."""
NUM_STARTS = 3
_POSE = 6


@dataclass(frozen=True)
class UnifiedFit:
    """A fitted camera.

    Attributes:
        camera: The camera; `looks` as given.
        model: The model, a key of `MODELS`.
        statistics: Of the free intrinsics.
        residuals_px: Measured less fitted pixels of each view, shapes (N, 2).
        poses: Rotation vector and translation of each board in the image's frame, shape (V, 6).
    """

    camera: UnifiedCamera
    model: str
    statistics: FitStatistics
    residuals_px: tuple[np.ndarray, ...]
    poses: np.ndarray

    @property
    def rms_px(self) -> float:
        """Root mean square of the corners' distances from where the camera says."""
        return _rms(np.concatenate(self.residuals_px))

    @property
    def view_rms_px(self) -> tuple[float, ...]:
        """The same of each view."""
        return tuple(_rms(residuals) for residuals in self.residuals_px)


def fit_unified(
    views: Sequence[BoardView],
    size_px: tuple[int, int],
    *,
    center_px: tuple[float, float] | None = None,
    max_radius_px: float = 0.0,
    looks: str = "mirror_above",
    model: str = AUTO,
) -> UnifiedFit:
    """Fit the unified model to views of boards.

    Args:
        views: At least 3, in different poses.
        size_px: Width and height of the pictures.
        center_px: A first guess of the optical axis, the image's middle if not given.
        max_radius_px: Edge of the view, which the camera keeps; 0: none.
        looks: Where the camera looks, which the camera keeps.
        model: What is free: a key of `MODELS`, or `auto`: the simplest that a richer one of
            round, radial and full does not improve on beyond chance (F test, 1 %).

    Raises:
        ValueError: Too few views, values that are not finite, no start from which all boards can
            be placed, or parameters that the views do not determine.
    """
    _require_views(views)
    middle = ((size_px[0] - 1) / 2.0, (size_px[1] - 1) / 2.0)
    starts = _starts(views, size_px, center_px if center_px is not None else middle)
    if not starts:
        raise ValueError("no focal length was found with which every board can be placed")
    found = {"round": min((_refine(views, s, "round") for s in starts[:NUM_STARTS]), key=_cost)}
    chosen = "round"
    for name in NESTED[1:] if model == AUTO else (model,):
        found[name] = _refine(views, found[chosen][0], name)
        if model != AUTO or _is_better(found[chosen][1], found[name][1]):
            chosen = name
    vector, answer = found[chosen]
    camera = UnifiedCamera(
        width_px=size_px[0], height_px=size_px[1], max_radius_px=max_radius_px, looks=looks,
        **{name: float(v) for name, v in zip(INTRINSICS, vector, strict=False)},
    )  # fmt: skip
    ends = np.cumsum([len(view.pixels) for view in views])[:-1]
    residuals = tuple(np.split(-answer.fun.reshape(-1, 2), ends))
    poses = vector[len(INTRINSICS) :].reshape(-1, _POSE)
    return UnifiedFit(camera, chosen, _statistics(chosen, answer), residuals, poses)


def _refine(
    views: Sequence[BoardView], start: np.ndarray, model: str
) -> tuple[np.ndarray, OptimizeResult]:
    """Return the full vector and SciPy's answer; only what the model leaves free moves."""
    columns = _free_columns(model)
    num, own = columns.shape[1], len(INTRINSICS)
    first = np.linalg.lstsq(columns, start[:own], rcond=None)[0]
    rest = start[:own] - columns @ first

    def full(free: np.ndarray) -> np.ndarray:
        return np.concatenate((rest + columns @ free[:num], free[num:]))

    def residuals(free: np.ndarray) -> np.ndarray:
        vector = full(free)
        off = [
            view_pixels(vector[:own], pose, view.points_board) - view.pixels
            for view, pose in zip(views, vector[own:].reshape(-1, _POSE), strict=True)
        ]
        return np.nan_to_num(np.concatenate(off).ravel(), nan=1e4)

    def jacobian(free: np.ndarray) -> np.ndarray:
        vector = full(free)
        rows, at = np.zeros((2 * sum(len(v.pixels) for v in views), len(free))), 0
        for k, (view, pose) in enumerate(zip(views, vector[own:].reshape(-1, _POSE), strict=True)):
            by_own, by_pose = view_jacobian(vector[:own], pose, view.points_board)
            after = at + 2 * len(view.pixels)
            rows[at:after, :num] = (by_own @ columns).reshape(-1, num)
            first_pose = num + _POSE * k
            rows[at:after, first_pose : first_pose + _POSE] = by_pose.reshape(-1, _POSE)
            at = after
        return np.nan_to_num(rows)

    x = np.concatenate((first, start[own:]))
    # MINPACK: no bound is needed from these starts, and its one thread beats many on such matrices.
    found = least_squares(
        residuals, x, jacobian, method="lm", x_scale="jac", xtol=1e-10, ftol=1e-10, gtol=1e-10,
        max_nfev=300,
    )  # fmt: skip
    return full(found.x), found


def _starts(
    views: Sequence[BoardView], size_px: tuple[int, int], center_px: tuple[float, float]
) -> list[np.ndarray]:
    """Return starting vectors, the best first: a parabola of each focal length, boards placed."""
    scored = []
    for focal in START_SHARES * max(size_px):
        intrinsics = np.array([1.0, focal, focal, *center_px, 0.0, 0.0, 0.0, 0.0, 0.0])
        poses, off = [], 0.0
        for view in views:
            pose = board_pose(view.points_board, lift((view.pixels - center_px) / focal, 1.0))
            poses.append(pose)
            off += float(
                ((view_pixels(intrinsics, pose, view.points_board) - view.pixels) ** 2).sum()
            )
        if np.isfinite(off):
            scored.append((off, np.concatenate((intrinsics, *poses))))
    return [vector for _, vector in sorted(scored, key=lambda pair: pair[0])]


def _cost(found: tuple[np.ndarray, OptimizeResult]) -> float:
    return float(found[1].cost)


def _is_better(simple: OptimizeResult, rich: OptimizeResult) -> bool:
    """Return whether more parameters improve a fit by more than chance would (F test)."""
    dof, more = len(rich.fun) - len(rich.x), len(rich.x) - len(simple.x)
    if rich.cost <= 1e-18 * len(rich.fun):
        return bool(simple.cost > 1e-12 * len(rich.fun))
    ratio = (simple.cost - rich.cost) / more / (rich.cost / dof)
    return bool(fisher_f.sf(ratio, more, dof) < CHANCE)


def _statistics(model: str, answer: OptimizeResult) -> FitStatistics:
    """Return the statistics of the intrinsics, the poses being unknown as well."""
    num = len(MODELS[model])
    names = [*MODELS[model], *(f"pose {k // _POSE + 1}" for k in range(len(answer.x) - num))]
    every = fit_statistics(names, answer.x, answer.fun, answer.jac)
    return FitStatistics(
        MODELS[model], every.values[:num], every.cov[:num, :num], every.residual_sd, every.dof,
        every.condition,
    )  # fmt: skip


def _free_columns(model: str) -> np.ndarray:
    """Return the matrix (10, free) that turns the free intrinsics into all of them."""
    if model not in MODELS:
        raise ValueError(f"model must be one of {', '.join(MODELS)}, got {model!r}")
    names = [("fx_px", "fy_px") if name == "f" else (name,) for name in MODELS[model]]
    return np.array([[float(own in tied) for tied in names] for own in INTRINSICS])


def _rms(residuals: np.ndarray) -> float:
    return float(np.sqrt((residuals**2).sum(axis=1).mean()))


def _require_views(views: Sequence[BoardView]) -> None:
    if len(views) < MIN_BOARDS:
        raise ValueError(f"at least {MIN_BOARDS} views of the board are needed, got {len(views)}")
    for k, view in enumerate(views):
        if view.points_board.shape != view.pixels.shape or view.pixels.shape[1:] != (2,):
            raise ValueError(f"view {k + 1}: points and pixels must be two lists of (N, 2)")
        if len(view.pixels) < 6 or not np.isfinite(view.pixels).all():
            raise ValueError(f"view {k + 1}: at least 6 corners are needed, all finite")
