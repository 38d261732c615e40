"""Landmarks: files, and which point of a wide thing is seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multi_localizer.landmarks import Landmark, load_landmarks, positions

BOX = ((4.0, -1.0), (5.0, -1.0), (5.0, 1.0), (4.0, 1.0))
TOL_M = 1e-9


def test_the_ends_of_a_goal_are_its_posts_seen_from_in_front() -> None:
    right, left = Landmark(BOX).ends_seen(np.array([[0.0, 0.0]]))
    assert tuple(right[0]) == (4.0, -1.0) and tuple(left[0]) == (4.0, 1.0)


def test_seen_from_the_side_the_far_corner_is_an_end() -> None:
    right, left = Landmark(BOX).ends_seen(np.array([[3.0, 4.0]]))
    assert tuple(left[0]) == (5.0, 1.0) and tuple(right[0]) == (4.0, -1.0)


def test_the_middle_lies_between_both_ends_in_angle() -> None:
    mark = Landmark(BOX)
    place = np.array([1.0, 3.0])
    right, left = (np.arctan2(*(p[0] - place)[::-1]) for p in mark.ends_seen(place[None]))
    middle = np.arctan2(*(mark.point_seen(place) - place)[::-1])
    assert middle == pytest.approx(0.5 * (right + left), abs=TOL_M)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-8, 3.5), st.floats(-8, 8))
def test_moving_all_moves_what_is_seen(dx: float, dy: float, x: float, y: float) -> None:
    shift, place = np.array([dx, dy]), np.array([x, y])
    moved = tuple((a + dx, b + dy) for a, b in BOX)
    for seen in ("middle", "left", "right"):
        there = Landmark(moved, seen).point_seen(place + shift)
        assert there == pytest.approx(Landmark(BOX, seen).point_seen(place) + shift, abs=1e-6)


def test_the_packages_fields_load() -> None:
    ends = positions(load_landmarks("middle_size_field"))
    assert ends["goal_blue_left"][0] == pytest.approx([-4.11, -0.8])
    assert ends["goal_yellow_left"][0] == pytest.approx([4.11, 0.8])
    goals = positions(load_landmarks("middle_size_goals"))
    assert goals["goal_blue"][0] == pytest.approx([-4.385, 0.0])


def test_several_of_a_class_are_kept_in_order(tmp_path: Path) -> None:
    path = tmp_path / "poles.yaml"
    path.write_text("pole: {positions_m: [[0, 2], [3, 2.5]]}\n")
    assert positions(load_landmarks(path))["pole"].tolist() == [[0.0, 2.0], [3.0, 2.5]]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "expected a mapping of class"), ("{", "not YAML"), ("a: 3", "expected a mapping"),
        ("a: {places: []}", "places"), ("a: {seen: left}", "either positions_m or outlines_m"),
        ("a: {positions_m: []}", "no landmarks"), ("a: {positions_m: [[1]]}", r"\[x, y\]"),
        ("a: {positions_m: [[1, .nan]]}", "finite"), ("a: {positions_m: [[1, yes]]}", "numbers"),
        ("a: {positions_m: [[1, 2], [1, 2]]}", "two landmarks at one place"),
        ("a: {positions_m: [[1, 2]], seen: left}", "no ends"), ("a: {positions_m: 3}", "a: "),
        ("a: {positions_m: [[1, 2]]}\na: {positions_m: [[3, 2]]}", "'a' stands there twice"),
    ],
)  # fmt: skip
def test_a_file_that_is_none_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=words):
        load_landmarks(path)


def test_an_unknown_name_lists_the_known() -> None:
    with pytest.raises(ValueError, match="middle_size_field"):
        load_landmarks("moon")
