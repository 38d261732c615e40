from __future__ import annotations

import math

import numpy as np
import pytest
from floor_masks import ell, rectangle

from multi_localizer.floor_plan import FloorPlan, load_plan


def test_small_size_field_has_the_papers_measures():
    plan = load_plan("small_size_field")
    reach = sorted({round(float(c), 4) for c in plan.offsets[plan.normals[:, 0] > 0.5]})
    assert reach == [1.37, 1.55]
    assert set(plan.goals) == {"goal_yellow", "goal_blue"}


def test_a_rectangle_has_one_other_face():
    symmetries = rectangle(2.0, 1.0).symmetries
    assert [round(s.yaw, 6) for s in symmetries] == [0.0, round(math.pi, 6)]


def test_a_square_off_the_origin_has_four_faces():
    plan = FloorPlan(rectangle(1.0, 1.0).corners + (3.0, -2.0))
    assert len(plan.symmetries) == 4
    for motion in plan.symmetries:
        moved = motion @ plan.corners
        apart = np.linalg.norm(moved[:, None] - plan.corners[None], axis=-1).min(axis=1)
        assert apart.max() < 1e-9


def test_an_ell_has_none():
    assert len(ell().symmetries) == 1


def test_contains_knows_the_notch_of_an_ell():
    plan = ell()
    assert plan.contains(0.0, 0.8)
    assert not plan.contains(0.8, 0.8)
    assert not plan.contains(5.0, 0.0)


@pytest.mark.parametrize(
    ("corners", "word"),
    [
        ([[0, 0], [1, 0]], "N >= 3"),
        ([[0, 0], [0, 1], [1, 1], [1, 0]], "counter-clockwise"),
        ([[0, 0], [2, 0], [2, 2], [1, -1], [0, 2]], "cross"),
        ([[0, 0], [2, 2], [2, 0], [0, 2]], "does not cross itself"),
        ([[0, 0], [2, 0], [0, 2], [2, 2]], "does not cross itself"),
        ([[0, 0], [3600, 0], [3600, 2000]], "corners_m spans 3600 m: are they millimeters?"),
        ([[0, 0], [0, 0], [1, 0], [1, 1]], "differ"),
        ([[0, 0], [1, math.nan], [1, 1]], "finite"),
    ],
)
def test_a_border_that_is_none_is_refused(corners, word):
    with pytest.raises(ValueError, match=word):
        FloorPlan(np.array(corners, dtype=float))


def test_a_goal_in_millimeters_is_refused_and_one_behind_the_border_is_not():
    corners = rectangle(2.0, 1.0).corners
    assert FloorPlan(corners, goals={"goal": (2.9, 0.0)}).goals
    with pytest.raises(ValueError, match="goals_m.goal .* outside of a floor"):
        FloorPlan(corners, goals={"goal": (1550.0, 0.0)})


def test_a_file_is_read_and_its_unknown_keys_are_refused(tmp_path):
    path = tmp_path / "hall.yaml"
    path.write_text("corners_m: [[0, 0], [4, 0], [4, 3], [0, 3]]\ngoals_m: {door: [4, 1]}\n")
    plan = load_plan(str(path))
    assert plan.name == "hall" and plan.goals["door"] == (4.0, 1.0)
    path.write_text("corners_m: [[0, 0], [4, 0], [4, 3]]\ngoal_m: {}\n")
    with pytest.raises(ValueError, match="goals_m"):
        load_plan(str(path))
    path.write_text("corners_m: [[0, 0], [4, 0, 1], [4, 3]]\n")
    with pytest.raises(ValueError, match="2 values"):
        load_plan(str(path))
    with pytest.raises(ValueError, match="small_size_field"):
        load_plan("no_such_plan")
