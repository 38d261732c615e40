"""Legs and torso: feet that stand do not slip, sensors see what is there."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.people.body import body_parts, foot_offsets, part_places
from sim_bridge.people.config import PeopleConfig

CONFIG = PeopleConfig()


def test_at_first_both_feet_stand_side_by_side() -> None:
    assert np.allclose(foot_offsets(CONFIG, 0.0), [[0.0, 0.11], [0.0, -0.11]])


def test_one_foot_stands_on_the_floor_while_the_body_goes_on() -> None:
    walked = np.linspace(0.0, 7.0, 701)
    feet = np.array([w + foot_offsets(CONFIG, float(w))[:, 0] for w in walked])
    moves = np.abs(np.diff(feet, axis=0))
    # At each instant one foot rests; the other swings at twice the walking speed.
    assert np.allclose(moves.min(axis=1), 0.0, atol=0.006)
    assert np.median(moves.max(axis=1)) == pytest.approx(0.02, abs=1e-9)


def test_feet_never_part_by_more_than_a_step() -> None:
    ahead = [foot_offsets(CONFIG, w)[:, 0] for w in np.linspace(0.0, 5.0, 400)]
    assert np.abs(np.diff(ahead, axis=1)).max() <= CONFIG.step_m + 1e-9


def test_parts_turn_with_the_person() -> None:
    places = part_places(CONFIG, SE2(1.0, 2.0, np.pi / 2.0), 0.0)
    assert np.allclose(places, [[0.89, 2.0], [1.11, 2.0], [1.0, 2.0]])


def test_without_legs_there_is_one_body_down_to_the_floor() -> None:
    plain = PeopleConfig(has_legs=False)
    (body,) = body_parts(plain, 0)
    assert body.bottom == 0.0 and body.size[2] == plain.height_m
    assert part_places(plain, SE2(1.0, 2.0, 0.3), 1.0).shape == (1, 2)


def test_a_laser_sees_legs_low_and_the_torso_high() -> None:
    legs, torso = body_parts(CONFIG, 0)[:2], body_parts(CONFIG, 0)[2]
    assert all(leg.is_at_height(0.3) and not leg.is_at_height(1.0) for leg in legs)
    assert torso.is_at_height(1.0) and not torso.is_at_height(0.3)
