"""Teams that say whom they see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from team_builders import GOALS, SIX, team

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_problem import make_problem
from multi_localizer.team_told import take_told

CONFIG = TeamConfig(body_radius_m=0.0)


def _named(seed: int = 0) -> list:
    views, truth = team(SIX, seed=seed, noise=0.005)
    return [
        replace(view, known=tuple(f"r{k}" for k in ids))
        for view, ids in zip(views, truth, strict=True)
    ]


def test_names_that_fit_are_taken_and_poses_follow() -> None:
    found = take_told(make_problem(_named(), GOALS, CONFIG), CONFIG)
    assert found is not None
    assert np.all(found.belief == 1.0)
    assert np.all(np.hypot(*(found.fit.poses - SIX)[:, :2].T) < 0.1)


def test_a_bearing_without_a_name_is_left_to_geometry() -> None:
    views = _named()
    views[2] = replace(views[2], known=("", *views[2].known[1:]))
    assert take_told(make_problem(views, GOALS, CONFIG), CONFIG) is None


def test_names_that_contradict_each_other_are_left_to_geometry() -> None:
    views = _named()
    views[0] = replace(views[0], known=(*views[0].known[1:], views[0].known[0]))
    assert take_told(make_problem(views, GOALS, CONFIG), CONFIG) is None


def test_a_bearing_named_as_nobodys_does_not_count() -> None:
    views = _named()
    bearings = views[0].bearings.copy()
    bearings[0] += 1.0
    views[0] = replace(views[0], bearings=bearings, known=("stranger", *views[0].known[1:]))
    found = take_told(make_problem(views, GOALS, CONFIG), CONFIG)
    assert found is not None
    assert found.owner[0] == -1 and found.belief[0] == 0.0


def test_without_rough_poses_there_is_nowhere_to_start() -> None:
    views = [replace(view, rough=None) for view in _named()]
    assert take_told(make_problem(views, GOALS, CONFIG), CONFIG) is None
