"""Pictures of a calibration: residuals, and what was measured drawn over the images."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import Any

import cv2
import numpy as np

from floor_perception.board_view import BoardView
from floor_perception.mirror_fit import MirrorFit, mirror_radius
from floor_perception.unified_fit import UnifiedFit

DPI = 110
_MEASURED, _FITTED, _MISSED = (60, 200, 60), (40, 40, 240), (200, 80, 200)  # BGR
_ARROW_SCALE = 30.0


def mirror_picture(fit: MirrorFit, radii_px: np.ndarray, distances_m: np.ndarray) -> bytes:
    """Return a PNG: the curve r = f(R) with its 95 % band and the points; the residuals below."""
    figure, (top, bottom) = _figure((8.0, 7.0), (3.0, 1.4))
    R = np.linspace(0.02, 0.995, 200) * min(fit.horizon_radius, 1.15 * float(np.max(radii_px)))
    curve = fit.floor_distance(R)
    r, half = curve.values, curve.half_widths
    top.plot(R, r, color="tab:blue", label="fitted, eq. 26")
    top.fill_between(R, np.maximum(r - half, 0.0), r + half, alpha=0.25, label="95 %")
    top.plot(radii_px, distances_m, "k.", label="measured")
    top.axvline(fit.horizon_radius, color="tab:gray", ls=":", label="horizon")
    top.set_ylim(0.0, 1.3 * float(np.max(distances_m)))
    top.set_ylabel("distance on the floor r, m")
    top.legend(loc="upper left")
    bottom.axhline(0.0, color="tab:gray", lw=0.8)
    model = mirror_radius(distances_m, *fit.parameters)
    bottom.plot(model, fit.residuals_px, "k.")
    bad = fit.outliers()
    bottom.plot(model[bad], fit.residuals_px[bad], "ro", mfc="none", ms=10)
    bottom.set_xlim(top.get_xlim())
    bottom.set_xlabel("radius in the image R, px")
    bottom.set_ylabel("measured - fitted, px")
    return _png(figure)


def residual_picture(residuals_px: Sequence[np.ndarray], names: Sequence[str]) -> bytes:
    """Return a PNG: residuals of each view as points (du, dv), with the circle of their RMS."""
    figure, (axes, bars) = _figure((9.0, 4.4), (1.0, 1.0), is_side_by_side=True)
    for residuals, name in zip(residuals_px, names, strict=True):
        axes.plot(residuals[:, 0], residuals[:, 1], ".", ms=4, label=name)
    every = np.concatenate(list(residuals_px))
    rms = float(np.sqrt((every**2).sum(axis=1).mean()))
    turn = np.linspace(0.0, 2.0 * np.pi, 100)
    axes.plot(rms * np.cos(turn), rms * np.sin(turn), "k-", lw=0.8)
    axes.set_aspect("equal")
    axes.set_xlabel("measured - fitted u, px")
    axes.set_ylabel("v, px")
    values = [float(np.sqrt((r**2).sum(axis=1).mean())) for r in residuals_px]
    bars.barh(range(len(values)), values)
    bars.set_yticks(range(len(values)), [name[-24:] for name in names], fontsize=7)
    bars.invert_yaxis()
    bars.axvline(rms, color="k", lw=0.8)
    bars.set_xlabel("RMS, px")
    figure.tight_layout()
    return _png(figure)


def corners_picture(gray: np.ndarray, view: BoardView, residuals_px: np.ndarray) -> np.ndarray:
    """Return the part of a picture with the board, BGR: corners found, and fitted ones.

    Circles are what was found, crosses what the camera says; lines go the residual's way, 30
    times as long.
    """
    low = np.maximum(view.pixels.min(axis=0) - 40.0, 0.0).astype(int)
    high = np.minimum(view.pixels.max(axis=0) + 40.0, np.array(gray.shape[::-1]) - 1.0).astype(int)
    scale = max(1, round(900 / max(high - low)))
    part = gray[low[1] : high[1] + 1, low[0] : high[0] + 1]
    drawn = cv2.cvtColor(
        cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC),
        cv2.COLOR_GRAY2BGR,
    )
    for pixel, residual in zip(view.pixels, residuals_px, strict=True):
        found = (pixel - low + 0.5) * scale - 0.5
        fitted = found - residual * scale
        _dot(drawn, found, _MEASURED)
        cv2.drawMarker(drawn, _whole(fitted), _FITTED, cv2.MARKER_TILTED_CROSS, 8, 1, cv2.LINE_AA)
        end = found + residual * _ARROW_SCALE
        cv2.line(drawn, _whole(found), _whole(end), _MISSED, 1, cv2.LINE_AA)
    return np.asarray(drawn)


def edge_picture(gray: np.ndarray, fit: UnifiedFit) -> np.ndarray:
    """Return a picture, BGR, with the center, the edge of the view and rings each 15 degrees.

    The thick ring is what is straight sideways of the optical axis: the horizon of an upright one.
    """
    drawn = cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR)
    camera = fit.camera
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    for degrees in range(15, 166, 15):
        angle = np.radians(degrees)
        sign = -1.0 if camera.looks in ("mirror_above", "down") else 1.0
        ring = np.stack(
            (np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn),
             np.full_like(turn, sign * np.cos(angle))), -1,
        )  # fmt: skip
        if camera.looks == "forward":
            ring = ring[:, [2, 0, 1]]
        pixels = camera.project(ring)
        if np.isfinite(pixels).all():
            thickness = 2 if degrees == 90 else 1
            cv2.polylines(
                drawn, [np.rint(pixels).astype(np.int32)], True, _FITTED, thickness, cv2.LINE_AA
            )
    if camera.max_radius_px > 0.0:
        radius = round(camera.max_radius_px)
        cv2.circle(drawn, _whole(np.array(camera.center_px)), radius, _MEASURED, 2, cv2.LINE_AA)
    _dot(drawn, np.array(camera.center_px), _MEASURED)
    return np.asarray(drawn)


def points_picture(
    gray: np.ndarray | None, size_px: tuple[int, int], pixels: np.ndarray, residuals: np.ndarray
) -> np.ndarray:
    """Return a picture, BGR, with known points: circles measured, crosses fitted."""
    blank = np.full((size_px[1], size_px[0]), 255, np.uint8)
    drawn = cv2.cvtColor(gray if gray is not None else blank, cv2.COLOR_GRAY2BGR)
    for pixel, residual in zip(pixels, residuals, strict=True):
        _dot(drawn, pixel, _MEASURED)
        cv2.drawMarker(drawn, _whole(pixel - residual), _FITTED, cv2.MARKER_CROSS, 12, 1)
    return np.asarray(drawn)


def png(image: np.ndarray) -> bytes:
    """Return an image, BGR, as PNG."""
    return bytes(cv2.imencode(".png", image)[1])


def _dot(image: np.ndarray, at: np.ndarray, color: tuple[int, int, int]) -> None:
    cv2.circle(image, _whole(at), 6, color, 1, cv2.LINE_AA)


def _whole(point: np.ndarray) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))


def _figure(
    size_inch: tuple[float, float], shares: tuple[float, float], is_side_by_side: bool = False
) -> tuple[Any, tuple[Any, Any]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size_inch, dpi=DPI)
    if is_side_by_side:
        return figure, tuple(figure.subplots(1, 2, width_ratios=shares))
    return figure, tuple(figure.subplots(2, 1, height_ratios=shares))


def _png(figure: Any) -> bytes:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    out = BytesIO()
    FigureCanvasAgg(figure).print_png(out, metadata={"Software": None})
    return out.getvalue()
