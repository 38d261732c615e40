"""What a laser measures through panes, against geometry and shares by hand."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.glass import Glass
from sim_bridge.panes import Crossings, crossings, laser_distances, panes_of
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


def _measure(
    solids: list[Solid], degrees: list[float], opaque: float, reach: float = 1e3, seed: int = 0
) -> np.ndarray:
    panes = panes_of(solids)
    met = crossings(panes, np.array([0.0, 0.0, 0.5]), _beams(degrees), 100.0)
    distances = np.full(len(degrees), opaque)
    reaches = np.full(len(degrees), reach)
    return laser_distances(panes, met, distances, reaches, np.random.default_rng(seed))


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
    pane = _pane(
        2.0, specular_share=0.0, scatter_share=1.0, scatter_depth_m=0.2, scatter_fixed_share=0.0
    )
    ranges = _measure([pane], [0.0] * 4000, 2.5)
    assert ranges.min() >= 1.995 and ranges.max() <= 2.5
    # An exponential cut at 0.505 m: mean = 0.2 (1 - exp(-0.505 / 0.2)).
    assert ranges.mean() - 1.995 == pytest.approx(0.2 * (1.0 - np.exp(-2.525)), abs=0.01)


def test_echoes_too_weak_for_the_way_through_glass_are_lost() -> None:
    pane = _pane(2.0, transmission=0.5, **INVISIBLE)
    near, far = _measure([pane], [0.0], 4.0, reach=10.0), _measure([pane], [0.0], 7.0, reach=10.0)
    assert np.isfinite(near).all() and np.isinf(far).all()


def _dirty(seed: int, **glass: float) -> np.ndarray:
    """Return which of many beams on 4 m of pane come back from dirt."""
    degrees = np.degrees(np.arctan(np.linspace(-1.9, 1.9, 1900) / 1.995)).tolist()
    pane = _pane(2.0, specular_share=0.0, scatter_share=0.1, **glass)
    ranges = _measure([pane], degrees, 50.0, seed=seed)
    return ranges < 49.0


def test_dirt_stays_in_its_place_and_to_its_range() -> None:
    first, again = _dirty(1, scatter_fixed_share=1.0), _dirty(2, scatter_fixed_share=1.0)
    assert first.any() and np.array_equal(first, again)
    pane = _pane(2.0, specular_share=0.0, scatter_share=1.0, scatter_fixed_share=1.0)
    assert len(set(_measure([pane], [1.0] * 50, 9.0).round(9))) == 1


def test_the_rest_of_the_dirt_comes_and_goes() -> None:
    first, again = (_dirty(seed, scatter_fixed_share=0.0) for seed in (1, 2))
    both = (first & again).sum() / first.sum()
    assert both == pytest.approx(first.mean(), abs=0.08)


def test_fixed_and_loose_dirt_make_up_the_share_promised() -> None:
    # Beams meet it at 0 to 43.6 degrees; 400 panes of 190 places each.
    found = []
    for share in (0.0, 0.5, 1.0):
        pane = _pane(2.0, 0.0, specular_share=0.0, scatter_share=0.1, scatter_fixed_share=share)
        panes = panes_of([pane] * 400)
        num = 200 * 400
        met = Crossings(
            np.arange(num), np.repeat(np.arange(400), 200), np.full(num, 2.0),
            np.tile(0.02 * np.arange(200) + 0.01, 400), np.ones(num),
        )  # fmt: skip
        reach = np.full(num, 1e3)
        rng = np.random.default_rng(0)
        found.append((laser_distances(panes, met, np.full(num, 9.0), reach, rng) < 8.0).mean())
    assert found == pytest.approx([0.1] * 3, abs=0.004)


def test_a_world_without_panes_is_measured_as_it_is() -> None:
    assert _measure([], [0.0, 5.0], 3.0).tolist() == [3.0, 3.0]
