"""Echoes of a laser: slanted, dark and far surfaces do not always answer."""

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.config import LaserConfig
from sim_bridge.echoes import echo_reach
from sim_bridge.snapshot import snapshot
from sim_bridge.surfaces import NAMES, require_looks, surface_of
from sim_bridge.world import RobotPlacement, Wall, World

from .conftest import PERFECT

EVEN = LaserConfig(range_max_m=10.0, reach_factor=1.5, echo_log_sd=0.0)


def _reach(degrees: float, surface: str = "smooth") -> float:
    cos, made_of = np.array([np.cos(np.radians(degrees))]), np.array([NAMES.index(surface)])
    return float(echo_reach(EVEN, cos, made_of, np.random.default_rng(0))[0])


def test_the_reach_by_hand() -> None:
    assert _reach(0.0) == pytest.approx(15.0)
    assert _reach(60.0) == pytest.approx(15.0 * 0.5**0.5)
    # cos 80 = 0.17365, cos 88 = 0.03490; black reflects a sixteenth of plaster: a quarter as far.
    assert _reach(80.0) == pytest.approx(6.2507, abs=1e-3)
    assert _reach(88.0) == pytest.approx(2.8022, abs=1e-3)
    assert _reach(0.0, "dark") == pytest.approx(3.75)


def test_the_reach_varies_as_it_says() -> None:
    config = replace(EVEN, echo_log_sd=0.2)
    reach = echo_reach(config, np.ones(4000), np.zeros(4000, int), np.random.default_rng(0))
    assert np.log(reach / 15.0).mean() == pytest.approx(0.0, abs=0.01)
    assert np.log(reach / 15.0).std() == pytest.approx(0.2, rel=0.05)


def _beside_a_wall(surface: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the ranges of beams onto a wall 0.5 m to the left, and what they are in truth."""
    laser = {**PERFECT["laser"], "num_beams": 361, "fov_rad": np.pi, "echo_log_sd": 0.0}
    robot = RobotPlacement(
        model="segway_rmp50", position_m=(0, 0), overrides={"laser": laser, "sonar": None}
    )
    wall = Wall(from_m=(-30, 0.56), to_m=(30, 0.56), surface=surface)
    seen = snapshot(World(name="w", walls=(wall,), robots=(robot,)), SE2(0, 0, 0)).scan
    onto = seen.angles > np.radians(1.0)
    return seen.ranges[onto], 0.5 / np.sin(seen.angles[onto])


# 0.5 / cos = reach sqrt(cos) where cos = (0.5 / reach) ** (2 / 3); reach 15 m, or 3.75 m on black.
@pytest.mark.parametrize(("surface", "last_deg"), [("smooth", 84.056), ("dark", 74.872)])
def test_a_wall_answers_up_to_the_angle_that_its_echo_allows(surface: str, last_deg: float) -> None:
    ranges, truth = _beside_a_wall(surface)
    incidence = np.degrees(np.arccos(0.5 / truth))
    near, far = incidence < last_deg - 0.1, incidence > last_deg + 0.1
    assert np.allclose(ranges[near], truth[near], atol=1e-3)
    assert np.isinf(ranges[far]).all() and far.sum() > 3


def test_materials_by_name_texture_and_kind() -> None:
    assert surface_of("", "books") == "rough" and surface_of("dark", "books") == "dark"
    assert surface_of("", "") == "smooth" and surface_of("", "", "rough") == "rough"
    with pytest.raises(ValueError, match="smooth, dark, rough, cloth"):
        require_looks("", "velvet")
    with pytest.raises(ValueError, match="velvet"):
        Wall(from_m=(0, 0), to_m=(1, 0), surface="velvet")
