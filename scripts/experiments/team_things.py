"""Other things that a team sees: how many of them it locates, how well, and how many are not there.

The paper announces this as its next step (5). Three balls of one class lie on the field; each robot
sees those that nothing hides, in any order, and nobody says which bearing belongs to which ball.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.stats import chi2

from experiments.team_layouts import BODY_RADIUS, FIELD_X, FIELD_Y
from experiments.team_rows import Row, scene_of, timed
from experiments.team_views_sim import Scene, hidden
from multi_localizer.team_views import ObjectEstimate, RobotView

KIND, NUM_THINGS = "ball", 3
SIZES = (4, 10)
_SAME_M = 1.0
_LEAST_GAP_M = 0.5


def things_on(scene: Scene, seed: int) -> np.ndarray:
    """Return where the balls lie, (NUM_THINGS, 2): apart from each other and from robots."""
    rng = np.random.default_rng([seed, 99])
    taken = scene.layout.poses[:, :2]
    half = 0.5 * np.array([FIELD_X, FIELD_Y])
    while len(taken) < len(scene.layout.poses) + NUM_THINGS:
        place = rng.uniform(-half, half)
        if np.hypot(*(taken - place).T).min() > _LEAST_GAP_M:
            taken = np.vstack((taken, place))
    return taken[len(scene.layout.poses) :]


def with_things(scene: Scene, things: np.ndarray, seed: int) -> Scene:
    """Return the scene with the balls in each robot's view."""
    rng = np.random.default_rng([seed, 98])
    disks = np.column_stack(
        (scene.layout.poses[:, :2], np.full(len(scene.layout.poses), BODY_RADIUS))
    )
    views: list[RobotView] = []
    for view, pose in zip(scene.views, scene.layout.poses, strict=True):
        seen = rng.permutation(things[~hidden(pose[:2], things, disks)])
        bearings = np.arctan2(*(seen - pose[:2]).T[::-1]) - pose[2]
        bearings = bearings + rng.normal(0.0, scene.senses.noise, len(bearings))
        views.append(replace(view, object_bearings={KIND: bearings}))
    return replace(scene, views=tuple(views))


def judged_things(num_robots: int, seeds: Iterable[int]) -> dict[str, Any]:
    """Return what teams of one size make of the balls, bearings of 1 degree."""
    row = Row(table="things", title="", num_robots=num_robots)
    errors: list[float] = []
    nees: list[float] = []
    num_true = num_given = 0
    for seed in seeds:
        scene = scene_of(row, seed)
        things = things_on(scene, seed)
        solution, _ = timed(with_things(scene, things, seed), row)
        for thing, found in matched(things, solution.objects):
            off = found.position - thing
            errors.append(float(off @ off))
            nees.append(float(off @ np.linalg.solve(found.cov, off)))
        num_true, num_given = num_true + len(things), num_given + len(solution.objects)
    count = 2 * len(nees)
    return {
        "n": num_robots,
        "things": num_true,
        "located_share": len(errors) / num_true,
        "phantoms": num_given - len(errors),
        "rms_m": float(np.sqrt(np.mean(errors))) if errors else None,
        "nees": float(np.mean(nees)) if nees else None,
        "nees_band": [float(chi2.ppf(p, count)) / len(nees) for p in (0.025, 0.975)]
        if nees
        else None,
    }


def matched(
    things: np.ndarray, found: Iterable[ObjectEstimate]
) -> list[tuple[np.ndarray, ObjectEstimate]]:
    """Return things with what was found of them, the nearest in sum and within 1 m."""
    given = list(found)
    if not given:
        return []
    places = np.array([each.position for each in given])
    apart = np.hypot(*(things[:, None] - places).transpose(2, 0, 1))
    rows, columns = linear_sum_assignment(np.minimum(apart, _SAME_M))
    return [
        (things[r], given[c]) for r, c in zip(rows, columns, strict=True) if apart[r, c] < _SAME_M
    ]
