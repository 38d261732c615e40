"""Fitting eq. 26: the paper's figures come back; intervals hold; bad data are refused."""

import numpy as np
import pytest

from floor_perception.mirror_fit import fit_mirror, mirror_radius
from floornav_common.cameras.hyperboloidal_mirror import paper_camera

MIRROR = paper_camera()
DISTANCES = np.array([0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0])
RADII = MIRROR.floor_radius(DISTANCES)


def noisy(sd_px: float, seed: int) -> np.ndarray:
    return np.asarray(RADII + np.random.default_rng(seed).normal(0.0, sd_px, len(RADII)))


def test_the_curve_is_equation_26_turned_round() -> None:
    # By hand from A, B, C and H: gamma = C / (H A), xi = B sqrt(C) / A.
    H = (10.12**2 / 229800.0 - 0.02054**2) ** -0.5
    gamma, xi = 229800.0 / (H * 10.12), 0.02054 * 229800.0**0.5 / 10.12
    assert np.allclose(mirror_radius(DISTANCES, gamma, xi, H / 1000.0), RADII)


def test_the_papers_figures_come_back_from_exact_radii() -> None:
    fit = fit_mirror(RADII, DISTANCES)
    assert np.allclose(fit.abc().values, (10.12, 0.02054, 229800.0), rtol=1e-6)
    assert fit.height_m == pytest.approx(MIRROR.viewpoint_height)
    assert fit.horizon_radius == pytest.approx(MIRROR.horizon_radius)
    seen = fit.floor_distance(np.array([60.0, 80.0, 100.0, 105.0, 110.0, 114.0])).values
    assert np.allclose(seen, [0.305, 0.582, 1.621, 2.611, 6.199, np.inf], atol=0.001)


def test_a_known_height_is_kept_and_narrows_the_intervals() -> None:
    R = noisy(0.1, 0)
    free, held = fit_mirror(R, DISTANCES), fit_mirror(R, DISTANCES, MIRROR.viewpoint_height)
    assert held.height_m == MIRROR.viewpoint_height
    assert held.statistics.names == ("gamma_px", "xi")
    assert held.statistics.half_widths[1] < 0.5 * free.statistics.half_widths[1]
    assert held.statistics.condition < 0.5 * free.statistics.condition


def test_a_b_c_trade_off_where_the_curve_is_known() -> None:
    """The reason for the warning: radii good to 0.1 px leave A open, and r = f(R) known."""
    fit = fit_mirror(noisy(0.1, 0), DISTANCES)
    abc = fit.abc()
    assert abc.half_widths[0] > 0.5 * abc.values[0]
    assert fit.statistics.is_nearly_degenerate
    at = fit.floor_distance(np.array([60.0, 80.0, 100.0]))
    assert (at.half_widths < 0.015 * at.values).all()


def test_intervals_of_the_curve_hold_the_truth_as_often_as_they_say() -> None:
    at = np.array([60.0, 80.0, 100.0, 105.0])
    truth = MIRROR.floor_distance(at)
    held = []
    for seed in range(60):
        found = fit_mirror(noisy(0.2, seed), DISTANCES).floor_distance(at)
        held.append(np.abs(found.values - truth) < found.half_widths)
    # 95 % of 60, less four standard deviations.
    assert (np.mean(held, axis=0) > 0.83).all()


def test_a_mirror_of_another_size_and_xi_comes_back() -> None:
    for gamma, xi, H in ((400.0, 0.6, 0.9), (300.0, 1.0, 0.5), (150.0, 1.3, 0.3)):
        r = np.geomspace(0.3 * H, 12.0 * H, 15)
        fit = fit_mirror(mirror_radius(r, gamma, xi, H), r)
        assert np.allclose(fit.parameters, (gamma, xi, H), rtol=1e-4)


def test_the_order_of_the_data_changes_nothing() -> None:
    R, order = noisy(0.2, 3), np.random.default_rng(1).permutation(len(RADII))
    a, b = fit_mirror(R, DISTANCES), fit_mirror(R[order], DISTANCES[order])
    assert np.allclose(a.parameters, b.parameters, rtol=1e-5)
    assert np.allclose(a.residuals_px[order], b.residuals_px, atol=1e-5)


def test_a_misread_value_is_named() -> None:
    R = noisy(0.1, 5)
    R[6] += 2.0
    assert fit_mirror(R, DISTANCES).outliers().tolist() == [6]


def test_four_exact_radii_do() -> None:
    pick = [0, 4, 8, 13]
    fit = fit_mirror(RADII[pick], DISTANCES[pick])
    assert fit.statistics.dof == 1
    assert fit.xi == pytest.approx(0.973, abs=0.001)


@pytest.mark.parametrize(
    ("radii", "distances", "said"),
    [
        (RADII[:3], DISTANCES[:3], "at least 4 different values of radius"),
        (np.repeat(RADII[:3], 4), np.repeat(DISTANCES[:3], 4), "at least 4 different"),
        (RADII, np.full(len(RADII), 1.0), "different values of distance"),
        (RADII[8:], DISTANCES[8:], "span at least 25%"),
        (RADII[::-1], DISTANCES, "must grow with the distance"),
        (np.where(RADII > 100.0, np.nan, RADII), DISTANCES, "finite, got nan"),
        (RADII, np.where(DISTANCES > 2.0, np.inf, DISTANCES), "finite, got inf"),
        (RADII - 60.0, DISTANCES, "radius 1 must be > 0"),
        (RADII, -DISTANCES, "distance 1 must be > 0"),
        (RADII, DISTANCES[:-1], "one length"),
        (np.exp(DISTANCES), DISTANCES, "no mirror's curve"),
    ],
)
def test_data_that_tell_no_mirror_are_refused(radii, distances, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        fit_mirror(radii, distances)


def test_eq_26_is_refused_for_what_is_no_hyperboloid() -> None:
    r = np.geomspace(0.1, 3.0, 12)
    with pytest.raises(ValueError, match="xi = 1.3"):
        fit_mirror(mirror_radius(r, 150.0, 1.3, 0.3), r).abc()
