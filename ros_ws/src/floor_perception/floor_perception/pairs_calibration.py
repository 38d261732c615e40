"""`calibrate_mirror` from pairs of pixel radius and distance on the floor."""

from __future__ import annotations

from typing import Any

import numpy as np

from floor_perception import calibration_pictures as pictures
from floor_perception.calibration_input import Table
from floor_perception.calibration_outcome import LARGE_RMS_PX, WIDE_SHARE, Outcome, ViewOptions
from floor_perception.mirror_fit import MirrorFit, abc_of, fit_mirror
from floornav_common.calibration import Calibration, calibration_of
from floornav_common.cameras import hyperboloidal_mirror, radius_table, unified
from floornav_common.cameras.central import CentralCamera
from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera
from floornav_common.cameras.radius_table import RadiusTableCamera
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera

XI_LIMIT = 0.999
SHOWN_SHARES = (0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0)


def calibrate_pairs(
    table: Table, options: ViewOptions, kind: str, height_m: float | None = None
) -> Outcome:
    """Fit r = f(R) to pairs and make a camera of a kind from it; errors as of `fit_mirror`."""
    R, r = table.pixels, table.metres
    fit, warnings = fit_mirror(R, r, height_m), []
    if kind == hyperboloidal_mirror.KIND and fit.xi > XI_LIMIT:
        if len(fit.statistics.names) > 1 and fit.statistics.interval("xi")[0] > XI_LIMIT:
            raise ValueError(
                f"xi = {fit.xi:.3f} is above 1: no hyperboloid; use --kind unified or radius_table"
            )
        warnings.append(f"the best xi was {fit.xi:.3f}; it was held at {XI_LIMIT}, below 1")
        fit = fit_mirror(R, r, height_m, XI_LIMIT)
    max_radius = options.max_radius_px if options.max_radius_px is not None else float(R.max())
    outcome = Outcome(
        _camera_of_pairs(fit, table, options, kind, max_radius), fit.statistics, fit.rms_px,
        warnings=warnings,
    )  # fmt: skip
    shown = np.array(SHOWN_SHARES) * max_radius
    distances = fit.floor_distance(shown)
    outcome.header = ["radius, px", "distance, m", "95 % +-, m"]
    outcome.rows = [
        [float(a), float(b) if np.isfinite(b) else "horizon", float(c) if np.isfinite(c) else None]
        for a, b, c in zip(shown, distances.values, distances.half_widths, strict=True)
    ]
    outcome.values = _mirror_values(fit)
    outcome.derived = fit.abc() if fit.xi < 1.0 else None
    _warn_of_mirror(fit, table, outcome)
    text = "Above: the curve, its 95 % band and the measurements. Below: residuals; red: far off."
    outcome.add_picture("residuals.png", pictures.mirror_picture(fit, R, r), text)
    return outcome


def _camera_of_pairs(
    fit: MirrorFit, table: Table, options: ViewOptions, kind: str, max_radius: float
) -> FloorCamera:
    (width, height), (u, v) = options.size_px, options.middle_px
    size: dict[str, Any] = {
        "width_px": width, "height_px": height, "center_u_px": u, "center_v_px": v,
    }  # fmt: skip
    camera: CentralCamera
    if kind == unified.KIND:
        camera = UnifiedCamera(
            **size, xi=fit.xi, fx_px=fit.gamma_px, fy_px=fit.gamma_px, max_radius_px=max_radius,
            looks=options.looks,
        )  # fmt: skip
    elif kind == radius_table.KIND:
        distances = np.unique(table.metres)
        radii = [float(table.pixels[table.metres == r].mean()) for r in distances]
        camera = RadiusTableCamera(
            **size, radii_px=tuple(radii), distances_m=tuple(float(r) for r in distances),
            measured_height_m=fit.height_m, looks=options.looks,
        )  # fmt: skip
    else:
        A, B, C = (float(value) for value in fit.abc().values)
        camera = MirrorCamera(
            **size, a_px_per_mm=A, b_per_mm=B, c_px2=C, max_radius_px=max_radius
        )  # fmt: skip
    return FloorCamera(camera, fit.height_m, calibration=_known(fit, kind, options.center_sd_px))


def _known(fit: MirrorFit, kind: str, center_sd_px: float) -> Calibration | None:
    """Return how well the keys of the camera are known; None for a table of radii."""
    if kind == radius_table.KIND:
        return None
    if kind == unified.KIND:
        found = fit.functions(("fx_px", "fy_px", "xi", "height_m"), lambda p: p[[0, 0, 1, 2]])
    else:
        keys = ("a_px_per_mm", "b_per_mm", "c_px2", "height_m")
        found = fit.functions(keys, lambda p: np.append(abc_of(p), p[2]))
    center = ("center_u_px", "center_v_px") if center_sd_px > 0.0 else ()
    names = (*found.names, *center)
    cov = center_sd_px**2 * np.eye(len(names))
    cov[: len(found.names), : len(found.names)] = found.cov
    return calibration_of(dict(zip(names, np.eye(len(names)), strict=True)), cov)


def _mirror_values(fit: MirrorFit) -> dict[str, object]:
    values: dict[str, object] = {
        "gamma_px": fit.gamma_px, "xi": fit.xi, "height_m": fit.height_m,
        "horizon_radius_px": fit.horizon_radius, "num_pairs": len(fit.residuals_px), "abc": None,
    }  # fmt: skip
    if fit.xi < 1.0:
        abc = fit.abc()
        values["abc"] = {
            name: {"value": float(v), "half_width": float(h)}
            for name, v, h in zip(abc.names, abc.values, abc.half_widths, strict=True)
        }
    return values


def _warn_of_mirror(fit: MirrorFit, table: Table, outcome: Outcome) -> None:
    for k in fit.outliers():
        outcome.warnings.append(
            f"line {table.lines[k]}: {table.pixels[k]:g} px at {table.metres[k]:g} m lies "
            f"{fit.residuals_px[k]:+.1f} px off the curve of the others"
        )
    if fit.xi < 1.0:
        abc = fit.abc()
        share = abc.half_widths / abc.values
        if (share > WIDE_SHARE).any():
            told = ", ".join(
                f"{n.split('_')[0].upper()} +-{s:.0%}"
                for n, s in zip(abc.names, share, strict=True)
            )
            cure = "" if "height_m" not in fit.statistics.names else "; --height narrows them"
            outcome.warnings.append(
                f"A, B and C trade off against each other ({told}): do not compare them one by "
                f"one; r = f(R) is known as the table says{cure}"
            )
    if outcome.rms_px > LARGE_RMS_PX:
        outcome.warnings.append(f"residuals of {outcome.rms_px:.2f} px (RMS) are large")
