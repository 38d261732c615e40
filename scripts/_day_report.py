"""The page of a demo with goals, and its last lines on the screen."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from _day_figures import LOCALIZERS, localizer_tracks, surroundings
from _day_pictures import Panel, write_errors, write_maps, write_shots, write_zones
from _day_robot import OURS, pilot_of
from _day_watch import DayWatch
from _demo_report import write_tum
from experiments.goal_drives import GoalDrive
from floornav_common.reporting import Figures, Picture, Section, Table, write_html
from sim_bridge.robot_model import RobotModel
from sim_bridge.world import World

_ROWS = (
    ("goals reached", "reached", "d"), ("glass touched", "glass_touched", "d"),
    ("stops over 5 s", "stops_over_5s", "d"), ("collisions", "collisions", "d"),
    ("time [s]", "time_s", ".1f"), ("stood [s]", "stopped_s", ".1f"),
    ("driven [m]", "path_m", ".1f"), ("glass in the map", "glass_recall", ".0%"),
)  # fmt: skip
_MAPS = (
    "Black: occupied; light blue: inferred glass; white: free; gray: unknown; thin lines: what "
    "truly stands there. Both runs: same seed, people and goals; localized by what the robot "
    "senses, never by the truth. The right one runs offline, in lockstep."
)
_ZONES = (
    "Orange: how near the nearest person came to the robot; bands: the planner's state. Below: the "
    "robot's speed."
)
_LEFT_OUT = (
    "Left out: floor_localizer needs a floor whose whole border one look shows, and "
    "landmark_localizer four landmarks in view; rooms full of furniture give neither."
)


def write_day(
    out: Path,
    world: World,
    model: RobotModel,
    watch: DayWatch,
    usual: GoalDrive | None,
    values: dict[str, Any],
    problem: str,
) -> None:
    """Write trajectories, pictures and `report.html`."""
    heard, start, around = watch.heard, world.robots[0].pose, surroundings(world, model)
    tracks = localizer_tracks(watch, start)
    for name in LOCALIZERS:
        if name in tracks:
            write_tum(out / f"{name}.tum", tracks[name])
    write_tum(out / "ground_truth.tum", heard.record.truth)
    write_maps(out / "map.png", world, around.solids, _panels(watch, usual, values))
    sjmc = pilot_of(world, model, OURS).planner.sjmc
    zones = {"L_DANGER": sjmc.danger_m, "L_CAUTION": sjmc.caution_m}
    write_zones(out / "zones.png", heard.record, around.outline, around.torso_radius, zones)
    write_errors(out / "errors.png", tracks, heard.record.truth)
    pictures = write_shots(out, heard.shots)
    title = f"floornav demo: {world.description or world.name}"
    subtitle = "Every node its own process, over DDS, in simulated time"
    write_html(out, title, _sections(out, values, problem, pictures), subtitle)


def _panels(watch: DayWatch, usual: GoalDrive | None, values: Mapping[str, Any]) -> list[Panel]:
    heard, title = watch.heard, "floornav: laser, sonars, SJMC"
    panels = [Panel(title, heard.grid, heard.glass, heard.record, _at(values))]
    if usual is not None:
        title, touches = "as most drive today: laser, VFH+", _at(values["baseline"])
        panels.append(Panel(title, usual.grid, None, usual.record, touches))
    return panels


def _at(values: Mapping[str, Any]) -> np.ndarray:
    return np.array([touch["place_m"] for touch in values["touched"]]).reshape(-1, 2)


def _sections(
    out: Path, values: dict[str, Any], problem: str, pictures: list[Picture]
) -> list[Section]:
    maps = Picture(out / "map.png", _MAPS)
    return [
        Section("", [_first(values, problem), _table(values), maps]),
        Section("Zones and states over time", [Picture(out / "zones.png", _ZONES)]),
        *([Section("What the cameras saw", list(pictures))] if pictures else []),
        Section("Pose errors", [
            _pose_table(values), Picture(out / "errors.png", "Log scale; nothing fitted."),
            "stereo_localizer's voxel map was made from the world beforehand, as by a survey. "
            + _LEFT_OUT,
        ]),
        Section("Latency of every hop", [
            "From the instant that a message's stamp names (of the sensor reading it comes from) "
            "until this script had it, in real time. Messages without stamp have none.",
            _latency_table(values["latency_ms"]),
        ]),
        Section("Nodes", [_load_table(values["load"], values["inputs_handled"])]),
    ]  # fmt: skip


def _first(values: Mapping[str, Any], problem: str) -> Figures:
    state = ("result", problem.splitlines()[0], "bad") if problem else ("result", "done", "good")
    factor = values["rtf"]
    shares = [share for share in values["inputs_handled"].values() if share is not None]
    return Figures(
        [
            state,
            ("goals reached", f"{values['reached']} of {values['goals']}"),
            ("collisions", str(values["collisions"])),
            ("simulated", f"{values['sim_s']:.1f} s"),
            ("times real time", "–" if factor is None else f"{factor:.2f}"),
            ("least share of inputs handled", f"{min(shares):.1%}" if shares else "–"),
        ]
    )


def _table(values: Mapping[str, Any]) -> Table:
    usual = values["baseline"]
    rows = [
        [name, cell(values[key], form), "–" if usual is None else cell(usual[key], form)]
        for name, key, form in _ROWS
    ]
    return Table(["", "floornav", "as most robots drive today"], rows)


def cell(value: Any, form: str) -> str:
    """Return a figure as text; a dash for none."""
    return "–" if value is None else format(value, form)


def _pose_table(values: Mapping[str, Any]) -> Table:
    header = ["localizer", "poses", "mean [m]", "RMS [m]", "worst [m]", "RMS [deg]"]
    rows = [
        [name, e["poses"], *(cell(e[key], ".3f") for key in ("mean", "rms", "max", "rms_deg"))]
        for name, e in values["pose_error_m"].items()
    ]
    usual = values["baseline"]
    if usual is not None:
        e = usual["pose_error_m"]["laser"]
        figures = (cell(e[key], ".3f") for key in ("mean", "rms", "max", "rms_deg"))
        rows.append(["the usual robot's laser map", e["poses"], *figures])
    return Table(header, rows)


def _latency_table(latency: Mapping[str, Mapping[str, Any]]) -> Table:
    rows = [
        [topic, row["messages"], cell(row["p50_ms"], ".1f"), cell(row["p99_ms"], ".1f")]
        for topic, row in latency.items()
    ]
    return Table(["topic", "messages", "median [ms]", "99th percentile [ms]"], rows)


def _load_table(load: Mapping[str, Any], shares: Mapping[str, float | None]) -> Table:
    rows = [
        [
            name,
            cell(row["cpu_share"], ".0%"),
            f"{row['rss_mb']:.0f}",
            cell(shares.get(name), ".1%"),
        ]
        for name, row in load.items()
    ]
    return Table(["process", "of one core", "memory [MB]", "inputs handled"], rows)


def last_lines(values: Mapping[str, Any]) -> list[str]:
    """Return what the command prints at the end."""
    lines = [_result_line("floornav", values)]
    if values["baseline"] is not None:
        lines.append(_result_line("laser + VFH+", values["baseline"]))
    poses = [f"{n} {e['rms']:.3f} m" for n, e in values["pose_error_m"].items() if e["poses"]]
    lines.append(f"pose errors (rms): {', '.join(poses) or 'none'}")
    shares = [(s, n) for n, s in values["inputs_handled"].items() if s is not None]
    if shares and values["rtf"] is not None:
        least, node = min(shares)
        lines.append(
            f"{values['rtf']:.2f} times real time; every node handled at least {least:.1%} of its "
            f"inputs ({node} the least)"
        )
    return lines


def _result_line(name: str, run: Mapping[str, Any]) -> str:
    glass = cell(run["glass_recall"], ".0%")
    return (
        f"{name + ':':14s}{run['reached']} of {run['goals']} goals in {run['time_s']:.0f} s, "
        f"glass touched {run['glass_touched']}, collisions {run['collisions']}, "
        f"stops over 5 s {run['stops_over_5s']}, glass in the map {glass}"
    )
