"""Time from the bearings of a whole team to all poses, beside peers that are told who is who.

Teams of 4 to 50 robots on the paper's field, 1 degree of noise, bodies that hide, rough poses
0.36 m and 15 degrees off. `fit alone` is the last fit of all poses, with true identities, from the
rough poses; it lays out its arrays anew each time, as gtsam builds its graph. `every_triangle_ms`
is the check of all triples of robots, as Kato et al. did it, for large teams scaled from a part.
Peers get the true identities and the same start. Floor: factoring the normal equations of all poses
once.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np
import scipy.linalg

from experiments.team_layouts import POSTS
from experiments.team_peers import count_triangles, gtsam_poses, num_triples, scipy_poses
from experiments.team_rows import Row, scene_of, timed
from experiments.team_views_sim import Scene
from experiments.timing import Case, median_and_p99, take_turns
from floornav_common.ros.threads import limit_threads
from multi_localizer.team_config import PublishedTeamConfig, TeamConfig
from multi_localizer.team_fit import TeamFit, fit_poses
from multi_localizer.team_problem import make_problem

SIZES = (4, 10, 20, 50)
NUM_SCENES, NUM_TURNS = 10, 5
_MOST_TRIPLES = 200


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return two cases for each size of team: with identification, and the fit alone."""
    limit_threads(1)
    return [case for num in SIZES for case in _cases(seed, num, say)]


def _cases(seed: int, num: int, say: Callable[[str], None]) -> list[Case]:
    say(f"team: {num} robots")
    row = Row(table="", title="", num_robots=num)
    ms: dict[str, list[np.ndarray]] = {}
    for number in range(NUM_SCENES):
        scene = scene_of(row, seed + number)
        calls: dict[str, Callable[[], object]] = {
            "whole": partial(timed, scene, row),
            "fit": partial(fit_alone, scene),
            "scipy": partial(scipy_poses, scene),
            "gtsam": partial(gtsam_poses, scene),
            "floor": partial(scipy.linalg.cho_factor, _equations(num)),
        }
        for name, values in take_turns(calls, NUM_TURNS).items():
            ms.setdefault(name, []).append(values)
    times = {name: np.concatenate(values) for name, values in ms.items()}
    median = {name: float(np.median(values)) for name, values in times.items()}
    triangles = {"every_triangle_ms": _every_triangle_ms(scene_of(row, seed), num)}
    others = {"scipy_ms": median["scipy"]}
    gtsam = "gtsam, told who is who"
    return [
        Case(
            f"identify and fit, {num} robots", *median_and_p99(times["whole"]), gtsam,
            median["gtsam"], median["floor"], {**others, **triangles},
        ),
        Case(
            f"fit alone, {num} robots", *median_and_p99(times["fit"]), gtsam, median["gtsam"],
            median["floor"], others,
        ),
    ]  # fmt: skip


def fit_alone(scene: Scene) -> TeamFit:
    """Return the fit of all poses to all bearings, whose identities are told."""
    config = TeamConfig()
    problem = make_problem(scene.views, POSTS, config)
    mark_seen = problem.kind_start[problem.mark_kind]  # one post in a class
    weight = problem.has_prior.astype(float)
    seen = np.concatenate(scene.true_ids)
    return fit_poses(problem, problem.prior, seen, mark_seen, weight, config.gate_sd)


def _equations(num: int) -> np.ndarray:
    J = np.random.default_rng(0).normal(size=(6 * num, 3 * num))
    return np.asarray(J.T @ J)


def _every_triangle_ms(scene: Scene, num: int) -> float:
    tolerance = PublishedTeamConfig().angle_tolerance_rad
    checked = min(num_triples(num), _MOST_TRIPLES)
    count_triangles(scene, tolerance, 1)  # compiles
    started = time.perf_counter()
    count_triangles(scene, tolerance, checked)
    return 1e3 * (time.perf_counter() - started) * num_triples(num) / checked
