"""Figures and pictures of a demo run: map and trajectories against the simulated truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from _demo_surface import FOUND_WITHIN_M, share_found
from _demo_watch import Heard, Track
from floornav_common.grid import OccupancyMap
from floornav_common.reporting import Figures, Picture, Section, Table, write_atomic, write_html
from floornav_common.se2 import SE2, wrap_angle
from sim_bridge.solids import Solid, distance_to_surface

OCCUPIED = 65


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
    return T_world_map @ grid.to_points(np.argwhere(grid.cells >= OCCUPIED))


def figures(
    heard: Heard, start: SE2, surfaces: list[Solid], visible: np.ndarray, wall_s: float
) -> dict[str, Any]:
    """Return the demo's own keys of `summary.json`.

    Trajectories are compared where they are: the map frame is the start pose, nothing is fitted.

    Args:
        heard: What came.
        start: Pose of the map frame in the world.
        surfaces: What stands at the height of the laser.
        visible: Points of it that the laser could see, (N, 2), m.
        wall_s: How long it took.
    """
    estimate = errors(in_world(heard.estimate, start), heard.truth)
    odometry = errors(in_world(heard.odometry, start), heard.truth)
    occupied = np.empty((0, 2))
    if heard.grid is not None:
        occupied = occupied_points(heard.grid, start)
    off = distance_to_surface(surfaces, occupied) if surfaces else np.empty(0)
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
        "map_found_share": share_found(visible, occupied),
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


def write_report(
    out: Path,
    title: str,
    values: dict[str, Any],
    problem: str,
    images: list[Picture],
    *,
    has_glass: bool,
) -> None:
    """Write `report.html`: picture and figures on the first screen; `has_glass`: of the world."""
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
            ("visible surface in the map", _percent(values["map_found_share"])),
            ("scans mapped", f"{values['scans_used']} of {values['scans']}"),
        ]
    )
    caption = (
        "Black: occupied cells; white: free; gray: unknown; blue: true outline at the height of "
        f"the laser{', thick and light: glass' if has_glass else ''}. A script drives the route by "
        "the mapper's pose; it does not look at the scan. Visible surface: what exact beams from "
        f"the true way reach{', but glass' if has_glass else ''}; in the map is what has an "
        f"occupied cell within {FOUND_WITHIN_M:g} m."
    )
    rows = [[key, _flat(value)] for key, value in values.items() if key not in ("packages",)]
    overview = out / "world.png"
    text = "The world in pybullet, the robot at its start."
    world_picture = [Section("World", [Picture(overview, text)])] if overview.exists() else []
    sections = [
        Section("", [shown, Picture(out / "map.png", caption)]),
        *world_picture,
        *([Section("Cameras", images)] if images else []),
        Section("Error over time", [Picture(out / "errors.png", "Log scale; nothing fitted.")]),
        Section("All figures", [Table(["key", "value"], rows)]),
    ]
    write_html(out, title, sections, "Every node its own process, over DDS, in simulated time")


def mapped_lines(values: dict[str, Any]) -> list[str]:
    """Return what the command says of a mapped world at the end."""
    lines = []
    if values["ate_m"]["rms"] is not None:
        lines.append(
            f"{values['path_m']:.1f} m driven in {values['sim_s']:.1f} s: trajectory error "
            f"{values['ate_m']['rms']:.3f} m rms (odometry alone ended "
            f"{values['odometry_final_error_m']:.2f} m off)"
        )
    if values.get("map_error_m") is not None:
        found = values["map_found_share"] or 0.0
        lines.append(
            f"map: occupied cells lie {values['map_error_m']:.3f} m from true surfaces (mean); "
            f"{100.0 * found:.1f} % of the surface that the laser could see is in it"
        )
    if values.get("glass_recall") is not None:
        lines.append(
            f"glass: {100.0 * values['glass_recall']:.0f} % of what it passed is in the map"
        )
    return lines


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


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.1f} %"


def _flat(value: Any) -> Any:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_flat(item)}" for key, item in value.items())
    return f"{value:.4g}" if isinstance(value, float) else value
