"""Maps of the recordings for docs/: their pictures, and the table of their figures."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from _docs_pictures import write_small
from _docs_references import LOCALIZER_HEAD, PLAN_HEAD, localizer_rows, plan_row
from _docs_tables import row_of, with_block, with_table
from _docs_trajectories import odometry, published_poses
from floornav_common.reporting import say, write_atomic
from grid_mapper.map_figures import loop_line
from grid_mapper.relations import load_relations, relation_errors
from grid_mapper.trajectory_metrics import Trajectory, load_tum, path_length, trajectory_errors

MAP_BAG = Path(__file__).resolve().parent / "map_bag.py"
LONG_NS = 60_000_000_000


@dataclass(frozen=True)
class Shown:
    """A recording that the docs show.

    Attributes:
        name: Name of the picture and of the row.
        path: Below the folder of the recordings.
        options: Further words of the command line.
        relations: File of known relations; "" for none.
        offset_s: Added to the trajectory's stamps to compare them.
        tolerance_s: How far a relation's stamp may be from a pose.
        has_localizer: Whether a localizer ran while it was recorded.
        plan: File of the floor's map; "" for none.
    """

    name: str
    path: str
    options: tuple[str, ...] = ()
    relations: str = ""
    offset_s: float = 0.0
    tolerance_s: float = 0.002
    has_localizer: bool = False
    plan: str = ""


SHOWN = (
    Shown("intel-lab", "intel-lab/intel_keyframes_rawodom_corrected.log.gz",
          relations="intel-lab/intel.relations.gz"),
    Shown("intel-lab-dense", "intel-lab/intel_posegraph.log.gz",
          relations="intel-lab/intel.relations.gz"),
    Shown("fr079-graph", "fr079/fr079_posegraph.log.gz",
          relations="fr079/fr079.relations.gz"),
    Shown("fr079", "fr079/fr079_corrected.log.gz", ("--no-odom",),
          relations="fr079/fr079.relations.gz", offset_s=1211.45, tolerance_s=0.1),
    Shown("wean-hall-1", "wean-hall/robotdata1.log.gz"),
    Shown("wean-hall-4", "wean-hall/robotdata4.log.gz"),
    Shown("mines-rover", "mines-rover/exp1.dat.gz"),
    Shown("olin_mac_floor1", "rosbag2/olin_mac_floor1",
          plan="rosbag2/olin_mac_floor1/mac_1st_floor_final.yaml"),
    Shown("pioneer_trace0", "rosbag2/pioneer_trace0", has_localizer=True),
    Shown("neato_wall_follower", "rosbag2/neato_wall_follower"),
    Shown("neato_drive_square", "rosbag2/neato_drive_square"),
)  # fmt: skip

NO_LOOPS = "loop_closing: false\n"
NAMES = tuple(shown.name for shown in SHOWN)
LOOP_LINE_OF = "intel-lab-dense"
"""What `map_bag` prints of its loops is shown in map-a-recording.md."""
SONARS = Shown("sonar8-mapping", "sonar8-mapping")
"""A recording without a laser: only its picture is shown, in map-glass.md."""

RUN_HEAD = (
    "| recording | scans | mapped | not trusted | way, m | way by odometry, m |"
    " ms a scan: median | p99 | memory, MB |\n" + "| --- " * 9 + "|\n"
)
LOOP_HEAD = (
    "| recording | nodes | loops closed | refused | ms a scan at most | times real time |\n"
    + "| --- " * 6
    + "|\n"
)
RELATION_HEAD = (
    "| recording: poses | relations matched | of them over a minute apart |"
    " translation, m: mean | median | deviation | rotation, deg: mean | median | deviation |"
    " distance to published poses, m RMS |\n" + "| --- " * 10 + "|\n"
)


def make_recordings(docs: Path, data: Path) -> None:
    """Map every recording that is there; write its picture and its rows as soon as it is mapped."""
    for shown in SHOWN:
        if not (data / shown.path).exists():
            say(f"passed over, not there: {data / shown.path}")
            continue
        with tempfile.TemporaryDirectory() as folder:
            make_recording(shown, docs, data, Path(folder))
    make_sonar_picture(docs, data)


def make_recording(shown: Shown, docs: Path, data: Path, folder: Path) -> None:
    """Map one recording, and write its picture and its rows.

    Args:
        shown: The recording.
        docs: Folder of the pages.
        data: Folder of the recordings.
        folder: For the results of the runs.
    """
    page, out = docs / "recordings.md", folder / "map"
    summary = map_recording(shown, data, out)
    relations: dict[str, str] = {}
    if shown.relations:
        map_recording(shown, data, folder / "open", NO_LOOPS)
        relations = _relation_rows(shown, data, out, folder / "open")
    write_small(out / "map.png", docs / "pictures" / f"{shown.name}.png")
    text = page.read_text(encoding="utf-8")
    tables = {
        "runs": (RUN_HEAD, {shown.name: _run_row(shown, data, summary)}),
        "loops": (LOOP_HEAD, {shown.name: _loop_row(shown, summary)}),
        "relations": (RELATION_HEAD, relations),
    }
    if shown.has_localizer:
        tables["localizer"] = LOCALIZER_HEAD, localizer_rows(shown.name, data / shown.path, out)
    if shown.plan:
        tables["plan"] = PLAN_HEAD, {shown.name: plan_row(shown.name, data / shown.plan, out)}
    for name, (head, rows) in tables.items():
        text = with_table(text, name, head, rows, NAMES)
    write_atomic(page, text)
    if shown.name == LOOP_LINE_OF:
        task_page = docs / "map-a-recording.md"
        block = f"```\n{loop_line(summary)}\n```"
        text = with_block(task_page.read_text(encoding="utf-8"), "loop line", block)
        write_atomic(task_page, text)
    say(f"written: {page}, {shown.name}")


def make_sonar_picture(docs: Path, data: Path) -> None:
    """Map the recording of sonars alone, if it is there, and write its picture."""
    if not (data / SONARS.path).exists():
        say(f"passed over, not there: {data / SONARS.path}")
        return
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "map"
        map_recording(SONARS, data, out)
        write_small(out / "map.png", docs / "pictures" / f"{SONARS.name}.png")


def map_recording(shown: Shown, data: Path, out: Path, config: str = "") -> dict[str, Any]:
    """Run the mapping command as a user does; return its summary.

    Args:
        shown: The recording.
        data: Folder of the recordings.
        out: Folder for the results.
        config: Text of a parameter file; "" for none.
    """
    words = [sys.executable, str(MAP_BAG), str(data / shown.path), *shown.options]
    if config:
        given = out.with_suffix(".yaml")
        given.write_text(config, encoding="utf-8")
        words += ["--config", str(given)]
    if shown.relations:
        words += ["--relations", str(data / shown.relations)]
        words += ["--relations-offset", str(shown.offset_s)]
        words += ["--relations-tol", str(shown.tolerance_s)]
    say(f"mapping {shown.name} ...")
    subprocess.run([*words, "--quiet", "--out", str(out)], check=True)
    summary: dict[str, Any] = json.loads((out / "summary.json").read_text())
    return summary


def _run_row(shown: Shown, data: Path, s: dict[str, Any]) -> str:
    has_odometry = "--no-odom" not in shown.options
    way = f"{path_length(odometry(data / shown.path)):.1f}" if has_odometry else "-"
    cells = [
        shown.name, s["scans"], s["scans_used"], s["scans_untrusted"], f"{s['path_m']:.1f}",
        way, f"{s['ms_median']:.2f}", f"{s['ms_p99']:.1f}", f"{s['peak_mb']:.0f}",
    ]  # fmt: skip
    return row_of(cells)


def _loop_row(shown: Shown, s: dict[str, Any]) -> str:
    reasons = ", ".join(f"{reason} {num}" for reason, num in s["loops_refused"].items())
    refused = f"{sum(s['loops_refused'].values())}" + (f": {reasons}" if reasons else "")
    times = f"{s['ms_max']:.0f}", f"{s['real_time_factor']:.1f}"
    return row_of([shown.name, s["nodes"], s["loops"], refused, *times])


def _relation_rows(shown: Shown, data: Path, out: Path, open_loops: Path) -> dict[str, str]:
    """Return the rows of a recording: ours with and without loops, odometry, published poses."""
    published = published_poses(data / shown.path)
    trajectories: dict[str, Trajectory] = {
        "grid_mapper": load_tum(out / "trajectory.tum"),
        "without closing loops": load_tum(open_loops / "trajectory.tum"),
    }
    if "--no-odom" not in shown.options:
        name = "chain of edges" if "posegraph" in shown.path else "raw odometry"
        trajectories[name] = odometry(data / shown.path)
    trajectories["published, corrected"] = published
    rows = {}
    for poses, trajectory in trajectories.items():
        ate = f"{trajectory_errors(trajectory, published).ate:.2f}"
        cells = [*_relation_cells(shown, data, trajectory), "-" if trajectory is published else ate]
        key = f"{shown.name}: {poses}"
        rows[key] = row_of([key, *cells])
    return rows


def _relation_cells(shown: Shown, data: Path, trajectory: Trajectory) -> list[str]:
    known = load_relations(data / shown.relations)
    errors = relation_errors(
        trajectory, known, round(shown.tolerance_s * 1e9), round(shown.offset_s * 1e9)
    )
    num_long = sum(abs(r.stamp2_ns - r.stamp1_ns) > LONG_NS for r in errors.relations)
    used = f"{len(errors.relations)} of {errors.num_total}"
    statistics = [
        f"{measure(values):{form}}"
        for values, form in ((errors.translations, ".3f"), (np.degrees(errors.rotations), ".2f"))
        for measure in (np.mean, np.median, np.std)
    ]
    return [used, str(num_long), *statistics]
