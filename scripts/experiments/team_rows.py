"""The rows of the team experiment beyond the paper's cases: what is seen, and how it is judged."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from experiments.team_faults import FAULTS
from experiments.team_judge import Verdict, bound_ratio, faulty_figures, figures, judge
from experiments.team_layouts import POSTS, random_layout
from experiments.team_views_sim import Scene, Senses, see, with_names
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_published import solve_published
from multi_localizer.team_solver import solve_team
from multi_localizer.team_views import TeamSolution

MANY_ROBOTS = 10
"""Of larger teams fewer layouts are run; each row still judges as many bearings or more."""
ROUGH_SD = (0.36, 0.36, float(np.radians(15.0)))
_TWICE = tuple(2.0 * sd for sd in ROUGH_SD)
_BLIND = {"sees_posts": False}


@dataclass(frozen=True, kw_only=True)
class Row:
    """One kind of team, seen on many layouts.

    Attributes:
        table: Key of `summary.json` that holds it.
        title: What is special to it.
        num_robots: Robots in the team.
        noise_deg: Deviation of a bearing.
        num_obstacles: Round things of 0.4 m that hide.
        fault: Name of what is wrong with one robot; "" for nothing.
        method: `team` or `published`.
        senses: Values of `Senses` that differ.
        body_radius: Told to the solver where it is not the robots' own.
        told_sd: Times the true deviation of a bearing is what the solver is told.
    """

    table: str
    title: str
    num_robots: int = 10
    noise_deg: float = 1.0
    num_obstacles: int = 0
    fault: str = ""
    method: str = "team"
    senses: dict[str, Any] = field(default_factory=dict)
    body_radius: float | None = None
    told_sd: float = 1.0


def _rows() -> Iterable[Row]:
    for num in (3, 4, 6, 10, 20, 30, 50):
        for noise in (0.5, 1.0, 2.0, 3.0):
            title = f"{num} robots, {noise:g} deg"
            yield Row(table="sweep", title=title, num_robots=num, noise_deg=noise)
    for title, changed in _VARIANTS.items():
        yield Row(table="variants", title=title, **changed)
    for fault in FAULTS:
        yield Row(table="faults", title=fault, fault=fault)
        yield Row(table="faults", title=f"{fault}, no posts", fault=fault, senses=_BLIND)
        yield Row(table="faults", title=f"{fault}, 4 robots", fault=fault, num_robots=4)
        for num in (3, 4):
            yield Row(
                table="faults", title=f"{fault}, {num} robots, no posts", fault=fault,
                num_robots=num, senses=_BLIND,
            )  # fmt: skip
    for num, noise in ((4, 1.0), (4, 3.0), (6, 1.0), (10, 1.0)):
        title = f"published, {num} robots, {noise:g} deg"
        yield Row(
            table="published", title=title, num_robots=num, noise_deg=noise, method="published"
        )

    for sd in (0.05, 0.1, 0.2, 0.36, 0.72):
        yield Row(
            table="published", title=f"published, 4 robots, 1 deg, rough poses {sd:g} m",
            num_robots=4, method="published", senses={"rough_sd": _rough_sd(sd)},
        )  # fmt: skip


def _rough_sd(sd_m: float) -> tuple[float, float, float]:
    """Return deviations of a rough pose whose yaw is as much better as its place."""
    return (sd_m, sd_m, sd_m / ROUGH_SD[0] * ROUGH_SD[2])


_VARIANTS: dict[str, dict[str, Any]] = {
    "as in the sweep": {},
    "told half the noise": {"told_sd": 0.5},
    "told twice the noise": {"told_sd": 2.0},
    "told bodies half as wide": {"body_radius": 0.075},
    "told bodies twice as wide": {"body_radius": 0.3},
    "nobody hides anybody": {"senses": {"hides": False}, "body_radius": 0.0},
    "rough poses twice as bad": {"senses": {"rough_sd": _TWICE}},
    "no rough poses": {"senses": {"rough_sd": None}},
    "no posts": {"senses": _BLIND},
    "no posts, nobody hides anybody": {
        "senses": {**_BLIND, "hides": False}, "body_radius": 0.0,
    },
    "no posts, rough poses twice as bad": {"senses": {**_BLIND, "rough_sd": _TWICE}},
    "4 obstacles": {"num_obstacles": 4},
    "12 obstacles": {"num_obstacles": 12},
    "10 % missing": {"senses": {"miss_share": 0.1}},
    "30 % missing": {"senses": {"miss_share": 0.3}},
    "0.5 false detections a robot": {"senses": {"num_false": 0.5}},
    "2 false detections a robot": {"senses": {"num_false": 2.0}},
    "4 obstacles, 10 % missing, 0.5 false": {
        "num_obstacles": 4, "senses": {"miss_share": 0.1, "num_false": 0.5},
    },
    "4 obstacles, 10 % missing, 0.5 false, no posts": {
        "num_obstacles": 4, "senses": {**_BLIND, "miss_share": 0.1, "num_false": 0.5},
    },
}  # fmt: skip
ROWS = tuple(_rows())


def num_layouts(row: Row, most: int) -> int:
    """Return how many layouts of a row are run: half of them where not in the sweep."""
    share = min(1.0, MANY_ROBOTS / row.num_robots) ** 1.5 * (1.0 if row.table == "sweep" else 0.5)
    return max(1, round(most * share))


def scene_of(row: Row, seed: int) -> Scene:
    """Return one layout of a row as its robots see it."""
    senses = Senses(noise=float(np.radians(row.noise_deg)), **row.senses)
    scene = see(random_layout(seed, row.num_robots, row.num_obstacles), senses, seed)
    told = tuple(replace(view, bearing_sd=row.told_sd * senses.noise) for view in scene.views)
    scene = replace(scene, views=told)
    return FAULTS[row.fault](scene) if row.fault else scene


def timed(scene: Scene, row: Row, *, named: bool = False) -> tuple[TeamSolution, float]:
    """Return what the row's method makes of a scene, and its time in ms.

    Args:
        scene: Of which it sees the views alone.
        row: Names the method.
        named: Whether the true identities are told, for the bound of the fit alone.
    """
    config = TeamConfig()
    if row.body_radius is not None:
        config = replace(config, body_radius_m=row.body_radius)
    views = with_names(scene) if named else scene.views
    solve = solve_team if row.method == "team" else solve_published
    started = time.perf_counter()
    solution = solve(views, POSTS, config)
    return solution, 1e3 * (time.perf_counter() - started)


def judged(row: Row, seeds: Iterable[int]) -> dict[str, Any]:
    """Return the figures of a row."""
    verdicts: list[Verdict] = []
    named: list[Verdict] = []
    for seed in seeds:
        scene = scene_of(row, seed)
        if not verdicts:
            timed(scene, row)  # compiles, and is not counted
        solution, ms = timed(scene, row)
        verdicts.append(judge(scene, solution, ms))
        if row.method == "team" and not row.fault:
            solution, ms = timed(scene, row, named=True)
            named.append(judge(scene, solution, ms))
    return {
        "title": row.title,
        "n": row.num_robots,
        "noise_deg": row.noise_deg,
        **figures(verdicts),
        **(faulty_figures(verdicts) if row.fault else {}),
        "crlb_ratio_named": bound_ratio(named),
        "suspects_share": float(np.mean([v.num_suspects > 0 for v in verdicts])),
    }
