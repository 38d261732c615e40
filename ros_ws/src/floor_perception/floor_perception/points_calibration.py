"""`calibrate_mirror` from points on the floor and their pixels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from floor_perception import calibration_pictures as pictures
from floor_perception.calibration_input import Table
from floor_perception.calibration_outcome import Outcome, ViewOptions, warn_of_fit
from floor_perception.points_fit import fit_points
from floornav_common.cameras.central import CentralCamera
from floornav_common.cameras.unified import UnifiedCamera


def calibrate_points(
    table: Table,
    options: ViewOptions,
    camera: CentralCamera | None,
    free: Sequence[str],
    position_m: tuple[float, float],
    gray: np.ndarray | None = None,
) -> Outcome:
    """Fit a mount, and the camera where it is free, to known points; errors as of `fit_points`."""
    start = camera if camera is not None else _start_camera(options)
    fit = fit_points(table.pixels, table.metres, start, free, position_m)
    outcome = Outcome(fit.floor_camera, fit.statistics, fit.rms_px)
    outcome.header = ["line", "x, m", "y, m", "off, px", "off, m"]
    seen = fit.floor_camera.floor_points(table.pixels) + fit.floor_camera.position_m
    off_m = np.hypot(*(seen - table.metres).T)
    outcome.rows = [
        [line, float(x), float(y), float(np.hypot(*off)), float(m) if np.isfinite(m) else None]
        for line, (x, y), off, m in zip(
            table.lines, table.metres, fit.residuals_px, off_m, strict=True
        )
    ]
    outcome.values = {"num_points": len(table.lines), "free": list(free)}
    warn_of_fit(outcome)
    text = "Residuals of all points; the circle is their RMS."
    drawn = pictures.residual_picture([fit.residuals_px], ["points"])
    outcome.add_picture("residuals.png", drawn, text)
    size = start.width_px, start.height_px
    image = pictures.points_picture(gray, size, table.pixels, fit.residuals_px)
    outcome.add_picture("points.png", pictures.png(image), "Circles measured, crosses fitted.")
    return outcome


def _start_camera(options: ViewOptions) -> UnifiedCamera:
    (width, height), (u, v) = options.size_px, options.middle_px
    focal = 0.25 * max(width, height)
    return UnifiedCamera(
        width_px=width, height_px=height, xi=1.0, fx_px=focal, fy_px=focal, center_u_px=u,
        center_v_px=v, looks=options.looks,
        max_radius_px=options.max_radius_px if options.max_radius_px is not None else 0.0,
    )  # fmt: skip
