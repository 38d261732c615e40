"""The page of a tour says what a world changes of how people are."""

import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from _tour_report import changed_people_model, people_section
from sim_bridge.world import load_world


def test_a_changed_model_of_people_is_in_the_report() -> None:
    changed = changed_people_model(load_world("sjmc_oncoming", {"notice_distance_m": 2.5}))
    assert changed == {"notice_distance_m": [2.5, 4.0]}
    (section,) = people_section(changed)
    assert section.blocks[1].rows == [["notice_distance_m", "2.5", "4.0"]]


def test_an_unchanged_one_is_not() -> None:
    assert changed_people_model(load_world("sjmc_oncoming")) is None
    assert people_section(None) == []
