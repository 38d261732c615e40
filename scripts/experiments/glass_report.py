"""Tables and pictures of `glass-map`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from experiments.glass_floors import EXPERIMENT
from experiments.glass_metrics import METRICS
from floornav_common.reporting import Picture, Section, Table

_HEADER = ["row", "recall", "precision", "seen", "false %", "wall cm", "phantoms %"]
_SCALE = {"false_occupied": 100.0, "wall_error_m": 100.0, "phantom_share": 100.0}


def sections(values: dict[str, Any], results: list[dict[str, Any]]) -> list[Section]:
    """Return what is shown of `glass-map`; see there for the values."""
    paper = [r for r in results if r["world"] in EXPERIMENT]
    floors = [r for r in results if r["world"] not in EXPERIMENT]
    return [
        Section("Lengths and angles of the paper's worlds", _table_blocks(values["tables"])),
        Section("The same over seeds, and on turned cells", _spread_blocks(values["lengths"])),
        *(Section(f"Experiment {EXPERIMENT[r['world']]}: {r['world']}", _world_blocks(r))
          for r in paper),
        Section(f"{len(floors)} drawn floors", _floor_blocks(values, floors)),
        Section("Paths", _path_blocks(values)),
    ]  # fmt: skip


def _table_blocks(entries: list[dict[str, Any]]) -> list[Any]:
    rows = [
        [f"{e['experiment']}{e['name']}", e["what"], e["method"], _length(e, "true"),
         _length(e, "measured"), _length(e, "error", signed=True),
         _length(e, "paper_error", signed=True)]
        for e in entries
    ]  # fmt: skip
    header = ["", "what", "row", "true", "measured", "error", "paper's error"]
    return ["Lines fitted to occupied cells, cm and deg, poses by ICP.", Table(header, rows)]


def _spread_blocks(entries: list[dict[str, Any]]) -> list[Any]:
    rows = [
        [f"{e['experiment']}{e['name']}", e["what"], e["method"], f"{e['turn_rad']:g}",
         f"{e['in_map']} of {e['seeds']}", _length(e, "error_rms"),
         _length(e, "error_worst", signed=True)]
        for e in entries
    ]  # fmt: skip
    header = ["", "what", "row", "turned, rad", "seeds", "error rms", "worst"]
    return ["Errors over seeds of the drive, cm and deg, poses by ICP.", Table(header, rows)]


def _length(entry: dict[str, Any], key: str, *, signed: bool = False) -> str:
    if entry[key] is None:
        return "not in the map"
    value = 100.0 * entry[key] if entry["unit"] == "m" else entry[key]
    return f"{value:+.1f}" if signed else f"{value:.1f}"


def _world_blocks(result: dict[str, Any]) -> list[Any]:
    rows = [_row(name, f) for name, f in result["icp"].items()]
    text = (
        f"{result['scans']} scans and {result['readings']} sonar readings on {result['way_m']:.0f} "
        f"m; poses off by {100 * result['pose_error_rms_m']:.1f} cm rms. `overlay` takes 26 key "
        "scans and each sonar's readings 5 cm apart."
    )
    return [text, Table(_HEADER, rows), *(Picture(Path(p)) for p in result["pictures"])]


def _row(name: str, figures: dict[str, Any] | None, suffix: str = "") -> list[str]:
    if figures is None:
        return [name, *["not available"] * len(METRICS)]
    return [name, *(_cell(m, figures.get(m + suffix)) for m in METRICS)]


def _cell(metric: str, value: float | None) -> str:
    if value is None or not np.isfinite(value):
        return "-"
    return f"{_SCALE.get(metric, 1.0) * value:.3f}"


def _floor_blocks(values: dict[str, Any], floors: list[dict[str, Any]]) -> list[Any]:
    if not floors:
        return ["None were asked for."]
    errors = [f["pose_error_rms_m"] for f in floors]
    text = (
        f"Poses by ICP on drifting odometry, off by {100 * float(np.median(errors)):.1f} cm rms "
        f"(median floor), {100 * max(errors):.1f} cm (worst floor); odometry ends "
        f"{float(np.median([f['odometry_end_error_m'] for f in floors])):.2f} m off (median)."
    )
    blocks: list[Any] = [text]
    for key, title in (("methods", "Poses by ICP"), ("methods_true_poses", "True poses")):
        for suffix, what in (("", "mean"), ("_median", "median floor"), ("_worst", "worst floor")):
            rows = [_row(name, f, suffix) for name, f in values[key].items()]
            blocks += [f"{title}: {what}.", Table(_HEADER, rows)]
    blocks += [Picture(Path(p)) for f in floors for p in f["pictures"]]
    return blocks


def _path_blocks(values: dict[str, Any]) -> list[Any]:
    text = (
        "A* on the map of each row (poses by ICP), inflated by 0.3 m, through free cells; the same "
        "start-goal pairs for all rows, spread over all worlds above. Goals truly reachable:"
    )
    asked = [[name, {True: "yes", False: "no", None: "-"}[is_so]]
             for name, is_so in values["reached"].items()]  # fmt: skip
    return [
        text, _path_table(values["paths"]),
        "Goals on free floor that was seen through glass, be there a way to it or not:",
        _path_table(values["paths_behind_glass"]),
        "What is asked of `bayes`:", Table(["", "reached"], asked),
    ]  # fmt: skip


def _path_table(paths: dict[str, Any]) -> Table:
    rows = [
        [name, *(["not available"] * 4 if s is None else
                 [str(s[k]) for k in ("pairs", "paths", "crossing", "crossing_faced")])]
        for name, s in paths.items()
    ]  # fmt: skip
    header = ["row", "pairs", "paths found", "through glass", "where a sonar had faced it"]
    return Table(header, rows)
