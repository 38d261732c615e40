"""Tables and pictures of the pose from the floor's shape."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from experiments.floor_pose_runs import View
from experiments.floor_pose_scenes import FieldCamera
from floornav_common.reporting import Figures, Picture, Section, Table
from floornav_common.se2 import SE2
from multi_localizer.floor_border import convex_hull, row_extremes
from multi_localizer.floor_fit import fit_published
from multi_localizer.floor_fitter import FloorShapeFitter
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.pose_estimate import difference

GOAL_MM, GOAL_DEG, GOAL_RATIO, GOAL_CALIBRATED = 10.0, 0.3, 1.2, 1.5
SURE_SHARE = 0.4
_PX_PER_M, _EDGE_M, _LEGEND_PX = 140.0, 0.1, 30
_BLACK = (0, 0, 0)
_GREEN, _RED, _BLUE, _WHITE = (60, 160, 60), (40, 40, 230), (230, 120, 30), (245, 245, 245)
Values = dict[str, Any]


def sections(values: Values, folder: Path) -> list[Section]:
    """Return the report."""
    picture = Picture(
        folder / "poses.png",
        "Above: pictures with the published hull (red) and the plan's border at the pose found "
        "(blue). Below: the field with where the hull's corners fall by the published pose (red) "
        "and the whole border by the pose found (blue).",
    )
    return [
        Section("Where am I by the floor's shape", [_figures(values)]),
        Section("Table 1: RMS errors at 256 x 220, ours and the paper's", [_cells(values, "")]),
        Section("The first ten poses of each place, as many as the paper has",
                [_cells(values, "", "positions_first_10")]),
        Section("640 x 480", [_cells(values, "_640x480")]),
        Section("Against the Cramer-Rao bound", [_bounds(values)]),
        Section("Hidden border", [_sweep(values["occlusion"], "share", "share hidden")]),
        Section("Calibration", [_sweep(values["calibration"], "error_px", "error, px", "kind")]),
        Section("Light", [_sweep(values["light"], "exposure", "exposure", "light")]),
        Section("Short drives, carried away once, with goals and odometry", [_drives(values)]),
        Section("Pictures", [picture]),
    ]  # fmt: skip


def _figures(values: Values) -> Figures:
    rows, known = values["positions"], values["occlusion"]
    worst = max(max(r["rms_x_mm"], r["rms_y_mm"]) for r in rows)
    turn = max(r["rms_theta_deg"] for r in rows)
    lost = sum(r["failures"] for r in known if r["share"] <= SURE_SHARE)
    ratio, found = values["crlb_ratio_median"], values["crlb_calibrated_ratio_median"]
    nees = values["consistency"]

    def mark(is_good: bool) -> str:
        return "good" if is_good else "bad"

    return Figures([
        ("largest RMS of x or y at a place", f"{worst:.1f} mm", mark(worst <= GOAL_MM)),
        ("largest RMS of the heading", f"{turn:.2f} deg", mark(turn <= GOAL_DEG)),
        ("over the bound, true mirror (median)", f"{ratio:.2f}", mark(ratio <= GOAL_RATIO)),
        ("over the bound, calibrated mirror", f"{found:.2f}", mark(found <= GOAL_CALIBRATED)),
        ("the same as the node comes, true mirror", f"{values['crlb_default_ratio_median']:.2f}"),
        ("the same as the node comes, calibrated",
         f"{values['crlb_calibrated_default_ratio_median']:.2f}"),
        (f"failures to {SURE_SHARE:.0%} hidden", str(lost), mark(lost == 0)),
        ("mean NEES (3 if covariances are true)", f"{nees['mean']:.2f}"),
        ("within the covariance's 95 %", f"{100.0 * nees['share_below_upper']:.1f} %"),
    ])  # fmt: skip


def _cells(values: Values, suffix: str, key: str = "positions") -> Table:
    header = ["x, y mm", "x mm", "paper", "y mm", "paper", "heading deg", "paper", "failures",
              "published steps here: x mm", "y mm", "deg"]  # fmt: skip
    rows = []
    for ours, old in zip(values[key + suffix], values["published" + suffix], strict=True):
        rows.append([
            f"{ours['x_mm']}, {ours['y_mm']}",
            round(ours["rms_x_mm"], 2), ours["paper_x_mm"],
            round(ours["rms_y_mm"], 2), ours["paper_y_mm"],
            round(ours["rms_theta_deg"], 3), ours["paper_theta_deg"],
            ours["failures"],
            round(old["rms_x_mm"], 1), round(old["rms_y_mm"], 1), round(old["rms_theta_deg"], 2),
        ])  # fmt: skip
    return Table(header, rows)


def _bounds(values: Values) -> Table:
    header = ["x, y mm", "true mirror: x mm (ratio)", "y mm", "deg",
              "calibrated: x mm (ratio)", "y mm", "deg",
              "default settings, ratios of x, y, heading: true mirror", "calibrated"]  # fmt: skip
    rows = []
    for row in values["bounds"]["rows"]:
        cells: list[Any] = [f"{row['x_mm']}, {row['y_mm']}"]
        for name in ("true", "calibrated"):
            for k, scale in enumerate((1e3, 1e3, math.degrees(1.0))):
                bound, ratio = scale * row[f"{name}_bound"][k], row[f"{name}_ratio"][k]
                cells.append(f"{bound:.3g} ({ratio:.2f})")
        for name in ("true_default", "calibrated_default"):
            cells.append(", ".join(f"{ratio:.2f}" for ratio in row[f"{name}_ratio"]))
        rows.append(cells)
    return Table(header, rows)


def _drives(values: Values) -> Table:
    d = values["drives"]
    header = ["drives", "masks", "given, right", "given, wrong", "open", "lost",
              "s to settle (largest)", "s to recover (largest)", "never settled",
              "never recovered"]  # fmt: skip
    times = [
        "-" if t["median"] is None else f"{t['median']:.1f} ({t['largest']:.1f})"
        for t in (d["settle_s"], d["recover_s"])
    ]
    return Table(header, [[
        d["drives"], d["masks"], d["settled"], d["wrong"], d["open"], d["lost"], *times,
        d["never_settled"], d["never_recovered"],
    ]])  # fmt: skip


def _sweep(rows: list[dict[str, Any]], key: str, title: str, name: str = "") -> Table:
    header = [*([name] if name else []), title, "RMS mm", "x mm", "y mm", "deg", "failures",
              "refused", "wrong and sure",
              "ambiguous", "poses", "published: RMS mm", "failures"]  # fmt: skip
    return Table(header, [
        [*([r[name]] if name else []), r[key], round(1e3 * r["rms_m"], 2),
         round(1e3 * r["rms_x_m"], 2), round(1e3 * r["rms_y_m"], 2),
         round(r["rms_theta_deg"], 3), r["failures"], r["refused"], r["wrong_and_sure"],
         r["ambiguous"], r["poses"],
         round(1e3 * r["published_rms_m"], 1), r["published_failures"]]
        for r in rows
    ])  # fmt: skip


def draw_views(
    field: FieldCamera, views: dict[tuple[int, int], list[View]], plan: FloorPlan, folder: Path
) -> None:
    """Draw one view of some places with what both fits make of it, into poses.png."""
    fitter = FloorShapeFitter(field.camera, plan)
    tiles = [_tile(field, at[0], plan, fitter) for at in list(views.values())[1:6:2]]
    drawn = np.hstack(tiles)
    cv2.imwrite(str(folder / "poses.png"), np.vstack((drawn, _legend(drawn.shape[1]))))


def _legend(width: int) -> np.ndarray:
    """Return a strip that says what the colors are."""
    strip = np.full((_LEGEND_PX, width, 3), _WHITE, np.uint8)
    texts = (
        (_RED, "published: hull, and where its corners fall"),
        (_BLUE, "ours: plan's border at the pose found, and where the border seen falls"),
    )
    for (color, text), column in zip(texts, (12, 12 + width * 2 // 5), strict=True):
        cv2.circle(strip, (column, _LEGEND_PX // 2), 5, color, -1, cv2.LINE_AA)
        at = (column + 12, _LEGEND_PX // 2 + 5)
        cv2.putText(strip, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.48, _BLACK, 1, cv2.LINE_AA)
    return strip


def _tile(field: FieldCamera, view: View, plan: FloorPlan, fitter: FloorShapeFitter) -> np.ndarray:
    fit = fitter.fit(view.mask)
    old = min(
        fit_published(view.mask, field.camera, plan),
        key=lambda p: abs(difference(p, view.pose)[2]),
    )
    new = view.pose
    if not fit.problem:
        new = min((c.pose for c in fit.candidates), key=lambda p: abs(difference(p, view.pose)[2]))
    image = cv2.resize(view.picture[..., ::-1], None, fx=1.75, fy=1.75)
    hull = convex_hull(row_extremes(view.mask))
    cv2.polylines(image, [_px(1.75 * hull)], True, _RED, 1, cv2.LINE_AA)
    outline = field.camera.floor_pixels(new.inverse() @ _dense(plan))
    cv2.polylines(image, [_px(1.75 * outline[np.isfinite(outline[:, 0])])], True, _BLUE, 1,
                  cv2.LINE_AA)  # fmt: skip
    floor = _floor(field, view, plan, old, new, fitter)
    return np.vstack((image, cv2.resize(floor, (image.shape[1], 260))))


def _floor(
    field: FieldCamera,
    view: View,
    plan: FloorPlan,
    old: SE2,
    new: SE2,
    fitter: FloorShapeFitter,
) -> np.ndarray:
    low = plan.corners.min(axis=0) - _EDGE_M
    high = plan.corners.max(axis=0) + _EDGE_M
    width, height = (int(n) for n in _PX_PER_M * (high - low))
    image = np.full((height, width, 3), _WHITE, np.uint8)

    def at(points: np.ndarray) -> np.ndarray:
        flat = _PX_PER_M * (points - low)
        return np.stack((flat[:, 0], height - flat[:, 1]), axis=-1)

    cv2.fillPoly(image, [_px(at(plan.corners))], _GREEN)
    border = fitter.scanner.scan(view.mask).values
    hull = field.camera.floor_points(convex_hull(row_extremes(view.mask)))
    for pose, points, color, radius in (
        (new, border[:, :2] / border[:, 2:3], _BLUE, 1),
        (old, hull[np.isfinite(hull[:, 0])], _RED, 2),
    ):
        for u, v in _px(at(pose @ points)).reshape(-1, 2):
            cv2.circle(image, (int(u), int(v)), radius, color, -1, cv2.LINE_AA)
    return image


def _dense(plan: FloorPlan) -> np.ndarray:
    """Return points along the border, a centimeter apart, (N, 2)."""
    return np.concatenate([
        corner + tangent * np.arange(0.0, length, 0.01)[:, None]
        for corner, tangent, length in zip(plan.corners, plan.tangents, plan.lengths, strict=True)
    ])  # fmt: skip


def _px(points: np.ndarray) -> np.ndarray:
    return np.rint(points).astype(np.int32).reshape(-1, 1, 2)
