"""sim_bridge/places.py: where a world file lets a robot drive."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from sim_bridge.places import Goals, Route
from sim_bridge.schema import WorldError
from sim_bridge.world import load_world


def test_goals_come_from_the_world_file_in_order() -> None:
    world = load_world("flat_day")
    assert world.goals is not None and len(world.goals.points_m) == 4
    assert all(math.isfinite(value) for place in world.goals.points_m for value in place)
    assert load_world("flat").goals is None


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Goals(points_m=()), "points_m must hold a place"),
        (lambda: Goals(points_m=((0.0, 0.0),), speed_m_s=0.0), "speed_m_s must be > 0"),
        (lambda: Route(waypoints_m=()), "waypoints_m must hold a place"),
        (lambda: Route(waypoints_m=((0.0, 0.0),), speed_m_s=float("nan")), "speed_m_s"),
    ],
)
def test_nowhere_and_no_speed_are_refused(make: Callable[[], object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        make()


def test_an_unknown_key_of_goals_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("name: mine\ngoals: {points_m: [[1, 2]], tempo: 3}\n")
    with pytest.raises(WorldError, match="tempo"):
        load_world(path)
