"""The laser's faults."""

from dataclasses import replace

import numpy as np
import pytest

from sim_bridge.config import LaserConfig
from sim_bridge.laser import angle_increment, beam_angles, measure

EXACT = LaserConfig(noise_sd_m=0.0, quantum_m=0.0, dropout_share=0.0, edge_share=0.0)


def test_beams_span_the_field_of_view() -> None:
    angles = beam_angles(LaserConfig(num_beams=271, fov_rad=np.radians(270.0)))
    assert np.degrees(angles[[0, 135, -1]]) == pytest.approx([-135.0, 0.0, 135.0])


def test_limits_are_reported_as_rep_117_says() -> None:
    ranges = measure(EXACT, np.array([0.01, 1.0, 10.5, np.inf]), np.random.default_rng(0)).ranges
    assert ranges.tolist() == [-np.inf, 1.0, np.inf, np.inf]


def test_noise_has_the_deviation_it_promises() -> None:
    config = LaserConfig(noise_sd_m=0.01, quantum_m=0.001, dropout_share=0.0)
    ranges = measure(config, np.full(20000, 3.0), np.random.default_rng(0)).ranges
    assert ranges.mean() == pytest.approx(3.0, abs=3e-4)
    assert ranges.std() == pytest.approx(0.01, rel=0.03)
    assert np.allclose(ranges, np.round(ranges, 3), atol=1e-6)


def test_dropouts_are_nan_at_the_share_promised() -> None:
    config = LaserConfig(dropout_share=0.1)
    ranges = measure(config, np.full(20000, 3.0), np.random.default_rng(0)).ranges
    assert np.isnan(ranges).mean() == pytest.approx(0.1, abs=0.01)


def test_a_range_max_below_range_min_is_refused() -> None:
    with pytest.raises(ValueError, match="range_max_m"):
        LaserConfig(range_min_m=2.0, range_max_m=1.0)


@pytest.mark.parametrize("degrees", [180.0, 240.0, 270.0])
def test_part_of_a_turn_ends_at_both_its_angles(degrees: float) -> None:
    angles = np.degrees(beam_angles(LaserConfig(num_beams=100, fov_rad=np.radians(degrees))))
    assert angles[[0, -1]] == pytest.approx([-degrees / 2.0, degrees / 2.0])


def test_a_full_turn_leaves_the_repeated_beam_out() -> None:
    config = LaserConfig(num_beams=360, fov_rad=2.0 * np.pi)
    assert np.degrees(angle_increment(config)) == pytest.approx(1.0)
    assert np.degrees(beam_angles(config))[[0, -1]] == pytest.approx([-180.0, 179.0])


def test_noise_grows_with_distance_where_it_is_told_to() -> None:
    config = LaserConfig(noise_sd_m=0.03, noise_sd_share=0.01, quantum_m=0.0, dropout_share=0.0)
    ranges = measure(config, np.full(20000, 4.0), np.random.default_rng(0)).ranges
    assert ranges.std() == pytest.approx(0.05, rel=0.03)


def test_only_edges_are_mixed_and_to_a_range_between() -> None:
    config = replace(EXACT, edge_share=1.0, num_beams=41)
    angles = np.linspace(-0.4, 0.4, 41)
    wall = 3.0 / np.cos(angles - 0.3)
    wall[20:] -= 0.3
    ranges = measure(config, wall, np.random.default_rng(0)).ranges
    changed = np.flatnonzero(np.abs(ranges - wall) > 1e-4)
    assert changed.tolist() == [19]
    assert wall[20] < ranges[19] < wall[19]
