"""Surface covariances: thin across a wall, wide along it, and they turn with the robot."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from grid_mapper.surface_points import surface_points

SIGMA, SPREAD = 0.02, 0.125


def on_line(angle: float) -> np.ndarray:
    along = np.arange(-0.2, 0.21, 0.04)[:, None]
    return np.array([1.0, 1.0]) + along * np.array([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2.0, 2.5])
def test_a_wall_is_thin_across_and_wide_along(angle):
    patch = surface_points(on_line(angle), np.zeros(2), 0.02, SIGMA, SPREAD)
    xx, xy, yy = patch.covs[5]
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    cov = np.array([[xx, xy], [xy, yy]])
    assert along @ cov @ along == pytest.approx(SPREAD**2, rel=1e-6)
    assert across @ cov @ across == pytest.approx(SIGMA**2, rel=1e-6)


def test_a_lone_point_is_as_vague_as_the_gap_to_the_next():
    patch = surface_points(np.array([[1.0, 2.0], [1.0, 2.9]]), np.zeros(2), 0.01, SIGMA, SPREAD)
    assert patch.covs == pytest.approx(np.array([[0.81, 0.0, 0.81]] * 2))
    assert (patch.normals == 0.0).all()


def test_normals_point_to_the_sensor_across_the_wall():
    wall = np.column_stack((np.full(9, 2.0), np.arange(-0.4, 0.41, 0.1)))
    seen_from = {-1.0: np.array([0.0, 0.0]), 1.0: np.array([5.0, 0.0])}
    for side, origin in seen_from.items():
        patch = surface_points(wall, origin, 0.05, SIGMA, SPREAD)
        assert patch.normals == pytest.approx(np.tile([side, 0.0], (9, 1)), abs=1e-9)


def test_covariances_turn_with_the_points():
    T = SE2(0.3, -0.4, 0.9)
    here = surface_points(on_line(0.3), np.zeros(2), 0.02, SIGMA, SPREAD).moved(T)
    there = surface_points(T @ on_line(0.3), np.array([T.x, T.y]), 0.02, SIGMA, SPREAD)
    assert here.points == pytest.approx(there.points)
    assert here.covs == pytest.approx(there.covs)


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"\(N, 2\)"):
        surface_points(np.zeros((4, 3)), np.zeros(2), 0.01, SIGMA, SPREAD)
