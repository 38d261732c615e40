"""Figures and pictures of a demo run: map and trajectories against the simulated truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from _demo_watch import Heard, Track
from floornav_common.grid import OccupancyMap
from floornav_common.reporting import Figures, Picture, Section, Table, write_atomic, write_html
from floornav_common.se2 import SE2, wrap_angle
from sim_bridge.solids import Solid, distance_to_surface

_OCCUPIED = 65
_INK, _TRUE, _EST, _ODO = "#1d2733", "#1a7f4b", "#e0641a", "#8a5cc2"


def in_world(track: Track, T_world_frame: SE2) -> Track:
    """Return a track in world coordinates."""
    return [(stamp, T_world_frame @ pose) for stamp, pose in track]


def errors(track_world: Track, truth: Track) -> np.ndarray:
    """Return (stamp_s, distance, |yaw error|) where both have the same stamp, shape (N, 3)."""
    true = dict(truth)
    rows = [
        (stamp * 1e-9, np.hypot(p.x - q.x, p.y - q.y), abs(wrap_angle(p.yaw - q.yaw)))
        for stamp, p in track_world
        if (q := true.get(stamp)) is not None
    ]
    return np.array(rows).reshape(-1, 3)


def occupied_points(grid: OccupancyMap, T_world_map: SE2) -> np.ndarray:
    """Return the middles of occupied cells in the world, shape (N, 2), m."""
    return T_world_map @ grid.to_points(np.argwhere(grid.cells >= _OCCUPIED))


def figures(heard: Heard, start: SE2, surfaces: list[Solid], wall_s: float) -> dict[str, Any]:
    """Return the demo's own keys of `summary.json`.

    Trajectories are compared where they are: the map frame is the start pose, nothing is fitted.
    """
    estimate = errors(in_world(heard.estimate, start), heard.truth)
    odometry = errors(in_world(heard.odometry, start), heard.truth)
    off = np.empty(0)
    if heard.grid is not None and surfaces:
        off = distance_to_surface(surfaces, occupied_points(heard.grid, start))
    return {
        "sim_s": round(heard.sim_s, 3),
        "rtf": heard.sim_s / wall_s if wall_s else None,
        "path_m": heard.path,
        "scans_used": len(heard.estimate),
        "ate_m": {"mean": _mean(estimate[:, 1]), "rms": _rms(estimate[:, 1])},
        "final_error_m": _last(estimate[:, 1]),
        "final_yaw_error_deg": _degrees(_last(estimate[:, 2])),
        "odometry_ate_m": {"mean": _mean(odometry[:, 1]), "rms": _rms(odometry[:, 1])},
        "odometry_final_error_m": _last(odometry[:, 1]),
        "odometry_final_yaw_error_deg": _degrees(_last(odometry[:, 2])),
        "map_error_m": _mean(off),
        "map_error_p95_m": float(np.percentile(off, 95)) if len(off) else None,
        "occupied_cells": len(off) or None,
    }


def write_tum(path: Path, track: Track) -> None:
    """Write a trajectory as `stamp x y z qx qy qz qw` lines, read by evo."""
    lines = [
        f"{stamp // 10**9}.{stamp % 10**9:09d} {p.x:.6f} {p.y:.6f} 0 0 0 "
        f"{np.sin(p.yaw / 2):.9f} {np.cos(p.yaw / 2):.9f}"
        for stamp, p in track
    ]
    write_atomic(path, "\n".join(lines) + "\n" if lines else "")


def write_pictures(out: Path, heard: Heard, start: SE2, solids: list[Solid], height: float) -> None:
    """Draw `map.png` (map, trajectories, true outline) and `errors.png` (error over time)."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(12.0, 9.4), layout="constrained")
    _draw_map(axes, heard, start)
    _draw_outline(axes, solids, height)
    _draw_tracks(axes, heard, start)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    _fit(axes, solids)
    for side in axes.spines.values():
        side.set_visible(False)
    figure.legend(loc="outside upper center", ncols=6, frameon=False, fontsize=12)
    figure.savefig(out / "map.png", dpi=110)
    plt.close(figure)

    figure, axes = plt.subplots(figsize=(12.0, 3.6), layout="constrained")
    for track, color, name in (
        (heard.odometry, _ODO, "odometry alone"),
        (heard.estimate, _EST, "grid_mapper"),
    ):
        rows = errors(in_world(track, start), heard.truth)
        axes.semilogy(rows[:, 0], np.maximum(rows[:, 1], 1e-4), color=color, label=name, lw=1.6)
    axes.set(xlabel="simulated time [s]", ylabel="position error [m]")
    axes.grid(alpha=0.25, which="both")
    axes.legend(frameon=False, ncols=2, loc="lower right")
    figure.savefig(out / "errors.png", dpi=110)
    plt.close(figure)


def write_overview(path: Path, image: np.ndarray) -> None:
    """Write a picture, shape (H, W, 3), RGB uint8."""
    from matplotlib.image import imsave

    imsave(path, image)


def write_report(out: Path, title: str, values: dict[str, Any], problem: str) -> None:
    """Write `report.html`: picture and figures on the first screen."""
    ate = values["ate_m"]["rms"] if values["ate_m"] else None
    state = ("result", problem.splitlines()[0], "bad") if problem else ("result", "done", "good")
    shown = Figures(
        [
            state,
            ("driven", _text(values["path_m"], "m", 1)),
            ("simulated", _text(values["sim_s"], "s", 1)),
            ("trajectory error (rms)", _text(ate, "m", 3)),
            ("odometry alone, at the end", _text(values["odometry_final_error_m"], "m", 2)),
            ("map to true surface (mean)", _text(values["map_error_m"], "m", 3)),
            ("scans mapped", f"{values['scans_used']} of {values['scans']}"),
        ]
    )
    caption = (
        "Black: occupied cells; white: free; gray: unknown; blue: true outline at the height of "
        "the laser. The robot steers by the mapper's pose."
    )
    rows = [[key, _flat(value)] for key, value in values.items() if key not in ("packages",)]
    overview = out / "world.png"
    text = "The world in pybullet, the robot at its start."
    world_picture = [Section("World", [Picture(overview, text)])] if overview.exists() else []
    sections = [
        Section("", [shown, Picture(out / "map.png", caption)]),
        *world_picture,
        Section("Error over time", [Picture(out / "errors.png", "Log scale; nothing fitted.")]),
        Section("All figures", [Table(["key", "value"], rows)]),
    ]
    write_html(out, title, sections, "Every node its own process, over DDS, in simulated time")


def _draw_map(axes: Any, heard: Heard, start: SE2) -> None:
    from matplotlib.transforms import Affine2D

    axes.set_facecolor("#d9dde2")
    if heard.grid is None:
        return
    grid = heard.grid
    shades = np.full((*grid.cells.shape, 4), 0.0)
    shades[(grid.cells >= 0) & (grid.cells < _OCCUPIED)] = (1.0, 1.0, 1.0, 1.0)
    shades[grid.cells >= _OCCUPIED] = (0.07, 0.09, 0.12, 1.0)
    rows, columns = grid.cells.shape
    T = start @ grid.origin
    image = axes.imshow(
        shades, origin="lower", interpolation="nearest",
        extent=(0.0, columns * grid.resolution, 0.0, rows * grid.resolution),
    )  # fmt: skip
    image.set_transform(Affine2D().rotate(T.yaw).translate(T.x, T.y) + axes.transData)


def _draw_outline(axes: Any, solids: list[Solid], height: float) -> None:
    has_label = {True: False, False: False}
    for solid in solids:
        corners = solid.outline()
        closed = np.vstack((corners, corners[:1]))
        is_seen = solid.is_at_height(height)
        label = None if has_label[is_seen] else "true outline" if is_seen else "above or below"
        has_label[is_seen] = True
        width, alpha, style = (1.0, 0.85, "-") if is_seen else (0.8, 0.5, ":")
        axes.plot(*closed.T, style, color="#2b7de0", lw=width, alpha=alpha, label=label)


def _draw_tracks(axes: Any, heard: Heard, start: SE2) -> None:
    for track, color, style, width, name in (
        (in_world(heard.odometry, start), _ODO, "--", 1.4, "odometry alone"),
        (heard.truth, _TRUE, "-", 4.0, "true path"),
        (in_world(heard.estimate, start), _EST, "-", 1.5, "grid_mapper"),
    ):
        if track:
            points = np.array([(pose.x, pose.y) for _, pose in track])
            axes.plot(*points.T, color=color, ls=style, lw=width, label=name)
    axes.plot(start.x, start.y, "o", ms=9, color=_TRUE, mec="white", label="start")


def _fit(axes: Any, solids: list[Solid]) -> None:
    corners = np.vstack([solid.outline() for solid in solids])
    (x0, y0), (x1, y1) = corners.min(axis=0) - 0.35, corners.max(axis=0) + 0.35
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)


def _mean(values: np.ndarray) -> float | None:
    return float(values.mean()) if len(values) else None


def _rms(values: np.ndarray) -> float | None:
    return float(np.sqrt((values**2).mean())) if len(values) else None


def _last(values: np.ndarray) -> float | None:
    return float(values[-1]) if len(values) else None


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else float(np.degrees(angle))


def _text(value: float | None, unit: str, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f} {unit}"


def _flat(value: Any) -> Any:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_flat(item)}" for key, item in value.items())
    return f"{value:.4g}" if isinstance(value, float) else value
