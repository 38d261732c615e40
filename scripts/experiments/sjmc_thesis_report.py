"""Tables and plots of the thesis's experiments, drawn as its figures are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from experiments.sjmc_thesis_drives import CROSSING, SLIM, STANDING, Outcome, Task
from floornav_common.reporting import Picture, Section, Table

NAMES = {
    "sjmc": "SJMC, ours", "sjmc_published": "SJMC, published", "vfh_plus": "VFH+", "vfh": "VFH",
    "vff": "VFF", "wavefront": "Wavefront", SLIM: "VFH+, disk of 0.45 m",
}  # fmt: skip
_BOUND = (
    "The most room that a robot with these limits can leave without turning, told that the person "
    "walks and backing as hard as it can: from rest told at once, from rest with the wait for the "
    "next scan, and with that wait from the speed at which sjmc creeps."
)
_DISKS = (
    "vfh_plus is told the disk about the base that holds the robot (0.57 m), vfh_plus_slim one of "
    "0.45 m, out of which the robot's tail looks; sjmc is told the box. time_s is the median over "
    "all runs; one that did not get past has its 60 s."
)
_COLORS = {
    "sjmc": "tab:green",
    "sjmc_published": "tab:orange",
    "vfh_plus": "tab:blue",
    SLIM: "tab:cyan",
}
_FOUND = {
    "5.2": "Thesis: VFH+ 6.7 s; times hardly differ up to C = 2.5 and rise from 2.7 on; C = 2.7, "
    "2.9 and 3.1 stay below 10.05 s, 1.5 times VFH+.",
    "5.3": "Thesis: the longer L_DANGER, the sooner it is past; C = 2.7 with L_DANGER = 1.9 m "
    "was chosen.",
    "5.5": "Thesis: SJMC keeps straight down to 1.3 m, VFH+ down to 2.7 m (7 runs a distance).",
    "5.2.4": "Thesis: Stable people could not be made to step aside.",
}  # fmt: skip


def sections(out_dir: Path, values: dict[str, Any], done: Mapping[Task, Outcome]) -> list[Section]:
    """Write the pictures and return the report."""
    found = []
    if values["aims"]:
        rows = [[r["aim"], r["found"], "met" if r["is_met"] else "missed"] for r in values["aims"]]
        found.append(Section("sjmc beside its aims", [Table(["aim", "found", ""], rows)]))
    if values["fig5_2"]:
        found += _static_sections(out_dir, values)
    if values["fig5_5"]:
        path = _draw_straight(out_dir / "fig5_5.png", values["fig5_5"])
        text = "Share of runs that kept straight; crosses: runs with a contact."
        blocks: list[Any] = [_FOUND["5.5"], _DISKS, _table(values["fig5_5"]), Picture(path, text)]
        blocks += [_BOUND, _table(values["fig5_5_bound"])]
        blocks.append(_draw_tracks(out_dir / "crossing.png", done, CROSSING, 2.1))
        found.append(Section("Fig. 5.5: straight run past who crosses", blocks))
    if any(row["runs"] for row in values["stable"]["methods"]["sjmc"].values()):
        found.append(_stable_section(out_dir, values["stable"], done))
    if values["table2_2"]:
        found.append(Section("Table 2.2, weaving counted", [_table(values["table2_2"])]))
    return found


def _static_sections(out_dir: Path, values: dict[str, Any]) -> list[Section]:
    rows = [
        [start, _short(v["ratio"]), _short(v["published_ratio"]),
         *(_short(v["time_s"][m]) for m in ("sjmc", "sjmc_published", "vfh_plus")),
         _short(v["vfh_plus_allowed_s"]), sum(v["contacts"].values())]
        for start, v in values["static"].items()
    ]  # fmt: skip
    header = ["start", "ours / VFH+", "published / VFH+", "ours s", "published s", "VFH+ s",
              "VFH+ may take s", "contacts"]  # fmt: skip
    fig2 = _draw_response(out_dir / "fig5_2.png", values["fig5_2"])
    fig3 = _draw_danger(out_dir / "fig5_3.png", values["fig5_3"])
    return [
        Section("Static obstacle", [Table(header, rows)]),
        Section("Fig. 5.2: time against C", [
            _FOUND["5.2"], _table(values["fig5_2"]),
            Picture(fig2, "Time against C, L_DANGER = 2 m."),
        ]),
        Section("Fig. 5.3: time against L_DANGER", [
            _FOUND["5.3"], _table(values["fig5_3"]), Picture(fig3, "Time against L_DANGER."),
        ]),
    ]  # fmt: skip


def _stable_section(out_dir: Path, stable: dict[str, Any], done: Mapping[Task, Outcome]) -> Section:
    rows = []
    for kind, by_method in (("standing", stable["methods"]), ("oncoming", stable["oncoming"])):
        for method, figures in by_method.items():
            for who in ("yielding", "unyielding"):
                row = figures[who]
                rows.append([kind, who, NAMES[method], *(_short(row[k]) for k in _STABLE_KEYS)])
    header = ["person", "who", "method", *_STABLE_KEYS]
    text = "success: who yields steps aside and the robot keeps within 10 degrees of straight on; "
    text += "who does not is passed; nothing is touched."
    picture = _draw_tracks(out_dir / "standing.png", done, STANDING, 0.0)
    return Section("5.2.4: Stable people", [_FOUND["5.2.4"], text, Table(header, rows), picture])


_STABLE_KEYS = ("success", "collisions", "by_robot", "stepped_aside", "min_gap_m", "time_s", "runs")


def _draw_response(path: Path, rows: list[dict[str, Any]]) -> Path:
    figure, axes = _figure(len(_starts(rows)))
    for ax, start in zip(axes, _starts(rows), strict=True):
        own = [r for r in rows if r["start_m"] == start]
        curve = [r for r in own if r["c"] is not None and r["time_s"] is not None]
        ax.errorbar(
            [r["c"] for r in curve], [r["time_s"] for r in curve], [r["sd_s"] for r in curve],
            marker="o", capsize=3, color=_COLORS["sjmc_published"], label=NAMES["sjmc_published"],
        )  # fmt: skip
        for row in own:
            if row["c"] is None and row["time_s"] is not None:
                name = row["method"]
                ax.axhline(row["time_s"], color=_COLORS[name], label=NAMES[name])
                if name == "vfh_plus":
                    ax.axhline(1.5 * row["time_s"], color=_COLORS[name], ls=":", label="1.5 x VFH+")
        ax.set(
            title=f"start {start:g} m before it", xlabel="C, s", ylabel="time, s", ylim=(0, None)
        )
        ax.legend(fontsize=8)
    figure.savefig(path)
    return path


def _draw_danger(path: Path, rows: list[dict[str, Any]]) -> Path:
    figure, axes = _figure(len(_starts(rows)))
    for ax, start in zip(axes, _starts(rows), strict=True):
        own = [r for r in rows if r["start_m"] == start and r["time_s"] is not None]
        for c in sorted({r["c"] for r in own}):
            curve = [r for r in own if r["c"] == c]
            ax.errorbar(
                [r["l_danger_m"] for r in curve], [r["time_s"] for r in curve],
                [r["sd_s"] for r in curve], marker="o", capsize=3, label=f"C = {c:g} s",
            )  # fmt: skip
        ax.set(title=f"start {start:g} m before it", xlabel="L_DANGER, m", ylabel="time, s")
        ax.set_ylim(0, None)
        ax.legend(fontsize=8)
    figure.savefig(path)
    return path


def _draw_straight(path: Path, rows: list[dict[str, Any]]) -> Path:
    figure, (ax,) = _figure(1)
    for method in dict.fromkeys(r["method"] for r in rows):
        own = sorted((r for r in rows if r["method"] == method), key=lambda r: r["distance_m"])
        x = [r["distance_m"] for r in own]
        ax.plot(
            x, [100 * r["straight"] for r in own], "o-", color=_COLORS[method], label=NAMES[method]
        )
        share = [100 * r["contacts"] / r["runs"] for r in own]
        ax.plot(x, share, "x:", color=_COLORS[method], alpha=0.7)
    ax.axvline(1.3, color="0.7", ls=":")
    ax.axvline(2.7, color="0.7", ls=":")
    ax.set(xlabel="distance at which the person sets out, m", ylabel="runs, %", ylim=(-3, 103))
    ax.legend(fontsize=8)
    figure.savefig(path)
    return path


def _draw_tracks(path: Path, done: Mapping[Task, Outcome], kind: str, distance: float) -> Picture:
    """Draw the first run of each method from above."""
    tasks = [t for t in done if t.kind == kind and t.number == 0 and t.is_yielding]
    if kind == CROSSING:
        nearest = min({t.distance for t in tasks}, key=lambda d: abs(d - distance))
        tasks = [t for t in tasks if t.distance == nearest]
    figure, axes = _figure(len(tasks))
    for ax, task in zip(axes, tasks, strict=True):
        run = done[task]
        ax.plot(run.track[:, 1], run.track[:, 2], ".-", color=_COLORS[task.method], ms=3)
        ax.plot(run.people[:, 1], run.people[:, 2], ".-", color="tab:red", ms=3)
        for row in run.track[::5]:
            _draw_robot(ax, row[1:], _COLORS[task.method])
        ax.set_title(
            f"{NAMES[task.method]}: {run.time_s:.1f} s, gap {run.min_gap_m:.2f} m", fontsize=9
        )
        ax.set_aspect("equal")
        ax.set(xlabel="x, m", ylabel="y, m")
    figure.savefig(path)
    text = (
        f"The first {kind} run of each method: the robot every second, the person red, every 0.1 s."
    )
    return Picture(path, text)


def _draw_robot(ax: Any, pose: np.ndarray, color: str) -> None:
    corners = np.array([[0.2, 0.28], [-0.49, 0.28], [-0.49, -0.28], [0.2, -0.28], [0.2, 0.28]])
    c, s = np.cos(pose[2]), np.sin(pose[2])
    placed = corners @ np.array([[c, s], [-s, c]]) + pose[:2]
    ax.plot(*placed.T, color=color, lw=0.6, alpha=0.7)


def _starts(rows: list[dict[str, Any]]) -> list[float]:
    return sorted({r["start_m"] for r in rows})


def _table(rows: list[dict[str, Any]]) -> Table:
    header = list(rows[0])
    return Table(header, [[_short(row[k]) for k in header] for row in rows])


def _short(value: Any) -> Any:
    return round(value, 2) if isinstance(value, float) else value


def _figure(columns: int) -> tuple[Any, list[Any]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2 * max(columns, 1), 4.2), dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(np.ravel(figure.subplots(1, max(columns, 1), squeeze=False)))
