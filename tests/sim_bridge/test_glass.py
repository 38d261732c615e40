"""Glass: Fresnel by hand, and the shares by angle."""

import numpy as np
import pytest

from sim_bridge.glass import (
    Frame,
    Glass,
    optical_delay,
    scatter_probability,
    specular_probability,
    transmittance,
)

NORMAL = np.ones(1)


def _at(degrees: float) -> np.ndarray:
    return np.array([np.cos(np.radians(degrees))])


def test_along_the_normal_a_pane_lets_through_what_it_promises() -> None:
    assert transmittance(Glass(transmission=0.7), NORMAL) == pytest.approx(0.7)


def test_a_clear_slab_follows_fresnel_at_a_right_angle() -> None:
    # n = 1.5: each face reflects 0.04, both together 2 * 0.04 / 1.04.
    clear = Glass(refractive_index=1.5, transmission=0.96 / 1.04)
    assert transmittance(clear, NORMAL) == pytest.approx(0.96 / 1.04)


def test_at_brewsters_angle_one_polarization_is_not_reflected_at_all() -> None:
    clear = Glass(refractive_index=1.5, transmission=0.96 / 1.04)
    brewster = np.degrees(np.arctan(1.5))
    # There R_s = ((1 - n^2) / (1 + n^2))^2 = 0.1479, R_p = 0.
    promised = 0.5 * (1.0 + (1.0 - 0.147929) / (1.0 + 0.147929))
    assert transmittance(clear, _at(brewster)) == pytest.approx(promised, abs=1e-5)


def test_less_and_less_light_goes_through_at_a_slant() -> None:
    shares = transmittance(Glass(), np.cos(np.radians(np.arange(0.0, 90.0, 5.0))))
    assert np.all(np.diff(shares) < 1e-9) and shares[-1] < 0.25


def test_the_mirror_return_has_half_its_share_at_its_half_width() -> None:
    glass = Glass(specular_share=0.8, specular_half_width_deg=5.0)
    assert specular_probability(glass, NORMAL) == pytest.approx(0.8)
    assert specular_probability(glass, _at(5.0)) == pytest.approx(0.4)
    assert specular_probability(glass, _at(15.0)) < 0.01


def test_dirt_counts_as_often_as_a_slanted_beam_is_longer_in_it() -> None:
    glass = Glass(scatter_share=0.1)
    assert scatter_probability(glass, _at(60.0)) == pytest.approx(1.0 - 0.9**2)


def test_glass_delays_light_by_its_index() -> None:
    glass = Glass(thickness_m=0.01, refractive_index=1.5)
    assert optical_delay(glass, NORMAL) == pytest.approx(0.005)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"transmission": 0.95}, "reflect the rest"),
        ({"thickness_m": 0.0}, "thickness_m"),
        ({"refractive_index": 1.0}, "refractive_index"),
        ({"scatter_share": 1.5}, "scatter_share"),
    ],
)
def test_impossible_glass_is_refused(values: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Glass(**values)


def test_a_frame_with_posts_that_overlap_is_refused() -> None:
    with pytest.raises(ValueError, match="spacing_m"):
        Frame(spacing_m=0.05, width_m=0.06)
