"""Who is taken for whom."""

from __future__ import annotations

import numpy as np

from sjmc_planner.scan_shapes import BEAMS, HALF, NUM_COLUMNS, RANGE, WIDTH, X, Y
from sjmc_planner.track_assignment import (
    CX,
    FIRST,
    FREE,
    NUM_CANDIDATE_COLUMNS,
    SECOND,
    assign,
    assign_late,
    candidates_of,
)
from sjmc_planner.track_filter import start


def shapes(*rows: tuple[float, float, float]) -> np.ndarray:
    """Return things at (x, y) with a width, all 2 m away."""
    table = np.zeros((len(rows), NUM_COLUMNS))
    for row, (x, y, width) in zip(table, rows, strict=True):
        row[[X, Y, WIDTH, HALF, BEAMS, RANGE]] = x, y, width, width / 2.0, 5.0, 2.0
    return table


def candidates(things: np.ndarray) -> np.ndarray:
    table = np.zeros((50, NUM_CANDIDATE_COLUMNS))
    num = candidates_of(things, len(things), np.zeros((len(things), 3)), 0.25, 0.85, table)
    return table[:num]


def tracks(*places: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    means, covs = np.empty((len(places), 2, 4)), np.empty((len(places), 2, 4, 4))
    for mean, cov, place in zip(means, covs, places, strict=True):
        start(mean, cov, *place, 0.1)
    return means, covs, np.full(len(places), 0.9)


def who(found: np.ndarray, *places: tuple[float, float]) -> list[tuple[int, int]]:
    """Return which things each track takes."""
    means, covs, p_walks = tracks(*places)
    taken, chosen = np.zeros(50, dtype=np.bool_), np.empty(len(places), dtype=np.int64)
    assign(found, len(found), means, covs, p_walks, len(places), taken, chosen)
    assign_late(found, len(found), means, p_walks, len(places), taken, chosen)
    return [(int(found[c, FIRST]), int(found[c, SECOND])) if c >= 0 else (-1, -1) for c in chosen]


def test_bodies_come_first_then_pairs_by_distance_then_legs() -> None:
    found = candidates(shapes((0.0, 0.0, 0.1), (0.5, 0.0, 0.1), (5.0, 5.0, 0.4), (0.2, 0.0, 0.1)))
    assert found[:, [FIRST, SECOND]].tolist() == [
        [2, -1], [0, 3], [1, 3], [0, 1], [0, -1], [1, -1], [3, -1]
    ]  # fmt: skip
    assert found[1, CX] == 0.1


def test_legs_too_far_apart_are_no_pair() -> None:
    found = candidates(shapes((0.0, 0.0, 0.1), (0.9, 0.0, 0.1)))
    assert (found[:, SECOND] == -1.0).all()


def test_a_person_takes_both_legs() -> None:
    found = candidates(shapes((0.3, 0.1, 0.1), (-0.3, -0.1, 0.1)))
    assert who(found, (0.0, 0.0)) == [(0, 1)]


def test_two_people_side_by_side_take_their_own_legs() -> None:
    found = candidates(
        shapes((0.2, 0.1, 0.1), (-0.2, -0.1, 0.1), (0.2, 0.9, 0.1), (-0.2, 0.7, 0.1))
    )
    assert who(found, (0.0, 0.0), (0.0, 0.8)) == [(0, 1), (2, 3)]


def test_nothing_is_taken_twice() -> None:
    found = candidates(shapes((0.0, 0.0, 0.4)))
    assert sorted(who(found, (0.05, 0.0), (0.0, 0.02))) == [(-1, -1), (0, -1)]


def test_what_is_far_is_nobodys() -> None:
    found = candidates(shapes((0.7, 0.0, 0.4)))
    assert who(found, (0.0, 0.0)) == [(-1, -1)]


def test_a_walker_somewhat_farther_on_is_still_the_same() -> None:
    found = candidates(shapes((0.42, 0.0, 0.4)))  # beyond the gate, 0.11 m of deviation
    assert who(found, (0.0, 0.0)) == [(0, -1)]


def test_who_stood_takes_a_body_one_step_off_where_all_was_free() -> None:
    found = candidates(shapes((0.28, 0.0, 0.4)))
    means, _, _ = tracks((0.0, 0.0))
    for free, expected in ((0.0, -1), (1.0, 0)):
        found[:, FREE] = free
        taken, chosen = np.zeros(50, dtype=np.bool_), np.array([-1])
        is_late = assign_late(found, len(found), means, np.array([0.01]), 1, taken, chosen)
        assert chosen[0] == expected and is_late[0] == (expected == 0)
