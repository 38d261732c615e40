"""`calibrate_mirror` from pictures of a checkerboard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from floor_perception import calibration_pictures as pictures
from floor_perception.board_view import BoardView
from floor_perception.calibration_input import read_gray
from floor_perception.calibration_outcome import Outcome, warn_of_fit
from floor_perception.checkerboard import board_points, find_corners, find_edge
from floor_perception.unified_fit import AUTO, MIN_BOARDS, UnifiedFit, fit_unified
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.progress import Progress


@dataclass(frozen=True)
class Boards:
    """What was found in the pictures.

    Attributes:
        grays: The pictures with a board, uint8.
        names: Of their files.
        views: The boards in them.
        lost: Names of files without one.
        mean: The mean of all pictures, uint8.
    """

    grays: list[np.ndarray]
    names: list[str]
    views: list[BoardView]
    lost: list[str]
    mean: np.ndarray


def calibrate_checkerboard(
    boards: Boards,
    center_px: tuple[float, float] | None = None,
    max_radius_px: float | None = None,
    looks: str = "mirror_above",
    model: str = AUTO,
) -> Outcome:
    """Fit the unified model to pictures of a board; errors as of `fit_unified`."""
    edge = find_edge(boards.mean)
    start = center_px if center_px is not None else (edge[:2] if edge is not None else None)
    size = boards.mean.shape[1], boards.mean.shape[0]
    fit = fit_unified(boards.views, size, center_px=start, looks=looks, model=model)
    radius = _edge_radius(edge, fit.camera) if max_radius_px is None else max_radius_px
    fit = replace(fit, camera=replace(fit.camera, max_radius_px=radius))
    outcome = Outcome(fit.camera, fit.statistics, fit.rms_px)
    outcome.header = ["picture", "corners", "RMS, px", "largest, px"]
    outcome.rows = [
        [name, len(off), rms, float(np.hypot(*off.T).max())]
        for name, off, rms in zip(boards.names, fit.residuals_px, fit.view_rms_px, strict=True)
    ]
    outcome.values = {
        "model": fit.model, "num_views": len(boards.views), "not_found": boards.lost,
        "view_rms_px": dict(zip(boards.names, fit.view_rms_px, strict=True)),
    }  # fmt: skip
    if boards.lost:
        outcome.warnings.append(f"no board was found in {', '.join(boards.lost)}")
    warn_of_fit(outcome)
    _add_pictures(outcome, boards, fit)
    return outcome


def find_boards(files: Sequence[Path], pattern: tuple[int, int], is_quiet: bool = False) -> Boards:
    """Find a board in each picture.

    Args:
        files: The pictures, all of one size.
        pattern: Inner corners of the board.
        is_quiet: Show no progress.

    Raises:
        ValueError: Pictures of several sizes, or fewer than 3 boards found.
        OSError: A picture cannot be read.
    """
    found, lost, total = [], [], None
    with Progress("finding corners", len(files), is_quiet=is_quiet) as progress:
        for k, path in enumerate(files):
            gray = read_gray(path)
            if total is not None and gray.shape != total.shape:
                raise ValueError(f"{path}: is {gray.shape[::-1]}, others {total.shape[::-1]}")
            total = gray.astype(float) if total is None else total + gray
            corners = find_corners(gray, pattern)
            if corners is None:
                lost.append(path.name)
            else:
                found.append((gray, path.name, BoardView(board_points(pattern), corners)))
            progress.update(k + 1, path.name, is_last=k + 1 == len(files))
    if total is None or len(found) < MIN_BOARDS:
        raise ValueError(
            f"the {pattern[0]}x{pattern[1]} board was found in {len(found)} of {len(files)} "
            f"pictures; at least {MIN_BOARDS} are needed"
        )
    grays, names, views = (list(column) for column in zip(*found, strict=True))
    return Boards(grays, names, views, lost, (total / len(files)).astype(np.uint8))


def _add_pictures(outcome: Outcome, boards: Boards, fit: UnifiedFit) -> None:
    residuals = fit.residuals_px
    text = "Residuals of all corners; the circle is their RMS. Right: RMS of each picture."
    outcome.add_picture("residuals.png", pictures.residual_picture(residuals, boards.names), text)
    text = "Green: center and edge of the view. Red: 15, 30 ... degrees from the axis; thick: 90."
    outcome.add_picture("view.png", pictures.png(pictures.edge_picture(boards.grays[0], fit)), text)
    for k, (gray, view, off) in enumerate(zip(boards.grays, boards.views, residuals, strict=True)):
        drawn = pictures.png(pictures.corners_picture(gray, view, off))
        text = (
            f"{boards.names[k]}: circles found, crosses fitted, lines residuals 30 times as long."
        )
        outcome.add_picture(f"corners_{k + 1}.png", drawn, text)


def _edge_radius(edge: tuple[float, float, float] | None, camera: UnifiedCamera) -> float:
    """Return the radius around the camera's center that stays inside the edge found; 0: none."""
    if edge is None:
        return 0.0
    off = float(np.hypot(*(np.array(camera.center_px) - edge[:2])))
    return max(edge[2] - off, 0.0)
