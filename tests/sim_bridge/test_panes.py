"""What a laser measures through panes, against geometry and shares by hand."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.glass import Glass
from sim_bridge.panes import crossings, laser_distances, panes_of
from sim_bridge.solids import Solid

TOL_M = 1e-9
INVISIBLE = {"specular_share": 0.0, "scatter_share": 0.0}


def _pane(x: float, yaw: float = np.pi / 2.0, length: float = 4.0, **glass: float) -> Solid:
    material = Glass(thickness_m=0.01, **glass)
    size = (length, 0.01, 2.0)
    return Solid("glass", SE2(x, 0.0, yaw), size, 0.1, False, (0.0, 0.0, 0.0), glass=material)


def _beams(degrees: list[float]) -> np.ndarray:
    angles = np.radians(degrees)
    return np.column_stack((np.cos(angles), np.sin(angles), np.zeros(len(angles))))


def _measure(solids: list[Solid], degrees: list[float], opaque: float, reach: float = 1e3):
    panes = panes_of(solids)
    met = crossings(panes, np.array([0.0, 0.0, 0.5]), _beams(degrees), 100.0)
    distances = np.full(len(degrees), opaque)
    return laser_distances(panes, met, distances, reach, np.random.default_rng(0))


def test_the_near_face_is_met_where_geometry_says() -> None:
    met = crossings(panes_of([_pane(2.0)]), np.array([0.0, 0.0, 0.5]), _beams([0.0, 40.0]), 9.0)
    assert met.beams.tolist() == [0, 1]
    assert met.distances == pytest.approx([1.995, 1.995 / np.cos(np.radians(40.0))], abs=TOL_M)
    assert np.degrees(np.arccos(met.cos_incidence)) == pytest.approx([0.0, 40.0], abs=1e-5)


def test_beams_beside_above_and_behind_a_pane_do_not_meet_it() -> None:
    panes = panes_of([_pane(2.0, length=1.0)])
    assert len(crossings(panes, np.array([0.0, 0.0, 0.5]), _beams([20.0, 180.0]), 9.0).beams) == 0
    assert len(crossings(panes, np.array([0.0, 0.0, 2.5]), _beams([0.0]), 9.0).beams) == 0
    assert len(crossings(panes, np.array([0.0, 0.0, 0.5]), _beams([0.0]), 1.5).beams) == 0


def test_a_pane_that_does_nothing_but_delay_only_delays() -> None:
    pane = _pane(2.0, refractive_index=1.5, **INVISIBLE)
    assert _measure([pane], [0.0], 5.0) == pytest.approx([5.005], abs=TOL_M)


def test_two_panes_delay_twice() -> None:
    panes = [_pane(x, refractive_index=1.5, **INVISIBLE) for x in (2.0, 3.0)]
    assert _measure(panes, [0.0], 5.0) == pytest.approx([5.010], abs=TOL_M)


def test_a_mirror_return_gives_the_near_face() -> None:
    pane = _pane(2.0, specular_share=1.0)
    assert _measure([pane], [0.0], 5.0) == pytest.approx([1.995], abs=TOL_M)


def test_a_pane_behind_something_opaque_changes_nothing() -> None:
    assert _measure([_pane(2.0, specular_share=1.0)], [0.0], 1.0) == pytest.approx([1.0])


def test_dirt_gives_points_behind_the_pane_never_beyond_what_is_there() -> None:
    pane = _pane(2.0, specular_share=0.0, scatter_share=1.0, scatter_depth_m=0.2)
    ranges = _measure([pane], [0.0] * 4000, 2.5)
    assert ranges.min() >= 1.995 and ranges.max() <= 2.5
    # An exponential cut at 0.505 m: mean = 0.2 (1 - exp(-0.505 / 0.2)).
    assert ranges.mean() - 1.995 == pytest.approx(0.2 * (1.0 - np.exp(-2.525)), abs=0.01)


def test_echoes_too_weak_for_the_way_through_glass_are_lost() -> None:
    pane = _pane(2.0, transmission=0.5, **INVISIBLE)
    near, far = _measure([pane], [0.0], 4.0, reach=10.0), _measure([pane], [0.0], 7.0, reach=10.0)
    assert np.isfinite(near).all() and np.isinf(far).all()


def test_half_the_echoes_are_lost_where_their_light_is_just_enough() -> None:
    ranges = _measure([_pane(2.0, transmission=0.5, **INVISIBLE)], [0.0] * 4000, 5.0, reach=10.0)
    assert np.isinf(ranges).mean() == pytest.approx(0.5, abs=0.03)


def test_a_world_without_panes_is_measured_as_it_is() -> None:
    assert _measure([], [0.0, 5.0], 3.0).tolist() == [3.0, 3.0]
