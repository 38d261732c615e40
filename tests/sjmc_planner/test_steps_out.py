"""Somebody who stood near the robot and sets out is known to walk at once."""

from __future__ import annotations

import numpy as np
from drawn_scans import Circle
from test_people_tracker import follow


def test_who_stood_near_and_steps_out_has_a_velocity_with_the_next_scan() -> None:
    """After 2 s at rest 1.5 m away: 0.13 m to the side in one scan, at 1.3 m/s."""

    def person(t: float) -> list[Circle]:
        return [(1.5, 0.8 - 1.3 * max(t - 1.95, 0.0), 0.2)]

    *_, before, after, later = follow(person, num=22)
    assert before.is_moving[0] < 0.1
    assert after.is_moving[0] > 0.5 and after.velocity[0, 1] < -0.3
    assert later.number.tolist() == before.number.tolist()
    assert later.velocity[0, 1] < -0.65


def test_who_sways_stays_where_it_is() -> None:
    def person(t: float) -> list[Circle]:
        return [(1.5, 0.8 + 0.02 * np.sin(5.0 * t), 0.2)]

    for tracks in follow(person, num=40)[5:]:
        assert len(tracks) == 1 and tracks.is_moving[0] < 0.5
