"""Tables of `team-localization`, and what of it was to be reached."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.team_paper_cases import METHODS, PAPER_ALONE, PAPER_TABLES, PAPER_TEAM
from experiments.team_pictures import draw_case, draw_sweep
from floornav_common.reporting import Picture, Section, Table

MOST_TO_ALONE, LEAST_IDENTIFIED, MOST_TO_BOUND = 0.6, 0.99, 1.3
MOST_MS = {10: 3.0, 50: 60.0}
_UNITS = {"x_mm": "x, mm", "y_mm": "y, mm", "theta_deg": "theta, deg"}
_METHOD_TITLES = {
    "circles": "alone, circles of method 1", "alone": "alone, least squares",
    "published": "team, as published", "team": "team, ours",
}  # fmt: skip
_HEADER = (
    "row", "identified %", "wrong %", "oracle %", "rms m", "bound m", "ratio when exact",
    "exact layouts", "ratio named", "ratio all", "NEES", "beyond 95 %", "answered %", "ms",
)  # fmt: skip


def sections(out: Path, values: dict[str, Any], seed: int) -> list[Section]:
    """Draw the pictures, fill `reached`, and return the report."""
    values["reached"] = reached(values)
    pictures = [
        draw_case(out / f"case_{k + 1}.png", f"Case {k + 1}", seed + k) for k in range(2)
    ] + draw_sweep(out, values["sweep"])
    return [
        Section("The paper's experiment: 4 robots", _paper_blocks(values)),
        Section("Robots and noise", [_GLOSSARY, _table(values["sweep"])]),
        Section("Variants: 10 robots, 1 deg", [_table(values["variants"])]),
        Section("One robot at fault: the others", _fault_blocks(values["faults"])),
        Section("As published, rough poses drawn", [_table(values["published"])]),
        Section("Other things: three balls, 1 deg", [_things_table(values["things"])]),
        Section("Every triangle", _triangle_blocks(values["every_triangle"])),
        Section("What was to be reached", [_reached_table(values["reached"])]),
        Section("Pictures", [Picture(path, text) for path, text in pictures]),
    ]


_GLOSSARY = (
    "identified: share of bearings to robots that got their true identity; oracle: the same by the "
    "true poses. bound: Cramer-Rao, from the same bearings, posts and rough poses with true "
    "identities. Ratio of rms errors to the bound: over layouts in which each bearing got its true "
    "identity, when the identities are told, and over all layouts. NEES in brackets: its 95 % "
    "band. beyond 95 %: share of poses with more than 7.8 squared deviations, 5 % if covariances "
    "are true. wrong: share of bearings that got another robot's identity."
)


def reached(values: Mapping[str, Any]) -> dict[str, bool | None]:
    """Return for each thing that was to be reached whether it was; None where it was not run."""
    sweep = {(row["n"], row["noise_deg"]): row for row in values["sweep"]}
    cases = {case["noise_deg"]: case for case in values["paper_cases"]}
    ratios = [r["crlb_ratio"] for r in values["sweep"] if r["crlb_ratio"] is not None]
    answer: dict[str, bool | None] = {
        f"team <= {MOST_TO_ALONE:g} x alone, {noise:g} deg": case["ratio_to_alone"] <= MOST_TO_ALONE
        for noise, case in cases.items()
    }
    answer["below 225 mm, 168 mm, 10 deg at 3 deg"] = all(
        cases[3.0]["team"][key] < limit for key, limit in PAPER_TEAM.items()
    )
    share = sweep[10, 1.0]["identified_share"]
    answer["identified >= 99 % at n = 10, 1 deg"] = share >= LEAST_IDENTIFIED
    answer["within 1.3 of the bound when identified, all rows"] = (
        max(ratios) <= MOST_TO_BOUND if ratios else None
    )
    for num, most in MOST_MS.items():
        slowest = max(row["solve_ms"] for row in values["sweep"] if row["n"] == num)
        answer[f"n = {num} in {most:g} ms, all rows"] = slowest <= most
    kept = [row["nees_kept"] for row in values["sweep"] if row["nees_kept"] is not None]
    answer["NEES in its 95 % band, nine rows of ten"] = (
        sum(kept) >= 0.9 * len(kept) if kept else None
    )
    return answer


def _paper_blocks(values: Mapping[str, Any]) -> list[Any]:
    blocks: list[Any] = [
        f"Mean absolute errors over {values['layouts']} layouts; of the deviations run, "
        f"{values['best_noise_deg']:g} deg fits the paper's errors of robots alone best."
    ]
    header = ["", *_UNITS.values(), "position, mm", "robots", "of alone"]
    for case in values["paper_cases"]:
        rows = [
            [_METHOD_TITLES[m], *(_number(case[m][key], 1) for key in _UNITS),
             _number(case[m]["position_mm"], 0), case[m]["answers"], _of_alone(case, m)]
            for m in METHODS
        ]  # fmt: skip
        for title, paper in (("paper, alone", PAPER_ALONE), ("paper, team", PAPER_TEAM)):
            rows.append([title, *(_number(paper[key], 0) for key in _UNITS), "", "", ""])
        text = (
            f"{case['noise_deg']:g} deg; identified {_percent(case['identified_share'])} %, as "
            f"published {_percent(case['published_identified_share'])} %; to the bound "
            f"{_number(case['crlb_ratio'], 2)}; NEES {_nees(case)}; {_number(case['solve_ms'], 2)} "
            f"ms, as published {_number(case['published_ms'], 2)} ms (paper: 30 ms)."
        )
        blocks += [text, Table(header, rows)]
    return [*blocks, *_tables_1_and_2(values)]


def _of_alone(case: Mapping[str, Any], method: str) -> str:
    key = {"team": "ratio_to_alone", "published": "published_ratio_to_alone"}.get(method)
    return "" if key is None else _number(case[key], 2)


def _tables_1_and_2(values: Mapping[str, Any]) -> list[Any]:
    """Return the paper's single robots beside the quartiles of ours."""
    rows = []
    for key, unit in _UNITS.items():
        for number, errors in enumerate(PAPER_TABLES[key], 1):
            rows.append([f"paper, Table {number}", unit, ", ".join(map(str, errors))])
        for case in values["paper_cases"]:
            for method in ("published", "team"):
                quartiles = case[method]["quartiles"]
                shown = "-" if quartiles is None else ", ".join(f"{q:.0f}" for q in quartiles[key])
                rows.append([f"{_METHOD_TITLES[method]}, {case['noise_deg']:g} deg", unit, shown])
    text = "Errors of robots A to D in the paper's two layouts, and the quartiles of ours."
    return [text, Table(["", "", "errors"], rows)]


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    return Table(
        list(_HEADER),
        [
            [
                row["title"], _percent(row["identified_share"]), _percent(row["wrong_share"]),
                _percent(row["oracle_share"]), _number(row["rms_m"], 3), _number(row["bound_m"], 3),
                _number(row["crlb_ratio"], 2),
                row["exact_layouts"], _number(row["crlb_ratio_named"], 2),
                _number(row["crlb_ratio_all"], 2), _nees(row), _percent(row["tail_share"]),
                _percent(row["answered_share"]), _number(row["solve_ms"], 2),
            ]
            for row in rows
        ],
    )  # fmt: skip


def _fault_blocks(rows: Sequence[Mapping[str, Any]]) -> list[Any]:
    header = [
        "fault",
        "identified %",
        "oracle %",
        "rms m",
        "NEES",
        "answered %",
        "suspected %",
        "its own pose %",
        "wrong %",
        "others' poses %",
        "others wrong %",
    ]
    cells = [
        [
            row["title"], _percent(row["identified_share"]), _percent(row["oracle_share"]),
            _number(row["rms_m"], 3), _nees(row), _percent(row["answered_share"]),
            _percent(row["suspects_share"]), _percent(row["faulty_published_share"]),
            _percent(row["faulty_wrong_share"]), _percent(row["honest_published_share"]),
            _percent(row["honest_wrong_share"]),
        ]
        for row in rows
    ]  # fmt: skip
    text = (
        "its own pose: how often the robot at fault is given a pose that would be published; "
        "wrong: how often that is more than 40 squared deviations off. others: the same of the "
        "robots that are not at fault."
    )
    return [text, Table(header, cells)]


def _things_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    header = ["robots", "balls", "located %", "not there", "rms m", "NEES (2 if true)"]
    cells = [
        [row["n"], row["things"], _percent(row["located_share"]), row["phantoms"],
         _number(row["rms_m"], 3), _nees(row)]
        for row in rows
    ]  # fmt: skip
    return Table(header, cells)


def _triangle_blocks(rows: Sequence[Mapping[str, Any]]) -> list[Any]:
    text = (
        "One layout each, 1 deg. Checking the angles of all triples of robots, and nothing else, "
        "beside our whole solve. Where it says so, a part was timed and scaled."
    )
    cells = [
        [row["n"], row["triples"], f"{row['combinations']:.3g}", f"{row['ms']:.3g}",
         "" if row["is_measured"] else "scaled", f"{row['solve_ms']:.3g}"]
        for row in rows
    ]  # fmt: skip
    header = ["robots", "triples", "combinations", "every triangle, ms", "", "our solve, ms"]
    return [text, Table(header, cells)]


def _reached_table(entries: Mapping[str, bool | None]) -> Table:
    words = {True: "yes", False: "NO", None: "-"}
    return Table(["", "reached"], [[name, words[is_so]] for name, is_so in entries.items()])


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{100.0 * value:.2f}"


def _nees(row: Mapping[str, Any]) -> str:
    if row["nees"] is None:
        return "-"
    low, high = row["nees_band"]
    return f"{row['nees']:.2f} ({low:.2f} to {high:.2f})"
