"""Parts of a scan that disagree: furniture that moved pulls a fit; noise alone does not."""

from __future__ import annotations

import numpy as np
import pytest
from worlds import box, moved_walls, scan_at, square_room

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.match_scatter import scatter_of
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.surface_points import points_of

CONFIG = GridMapperConfig().matcher
HERE = SE2.identity()
START_COV = np.diag([0.1, 0.1, 0.05]) ** 2
SHIFT_M = 0.25
MAX_SIGMA_M = GridMapperConfig().relocation.max_sigma_m
CORRIDOR = np.array([[-30.0, -1.2, 30.0, -1.2], [30.0, 1.2, -30.0, 1.2]])
"""Two walls, each past the laser's range at both ends."""


def pillars(*centers):
    return np.vstack([box(x - 0.2, y - 0.2, x + 0.2, y + 0.2) for x, y in centers])


STAYED = pillars((-2.0, -1.0), (-1.0, 1.0))
MOVED = pillars((1.2, -1.0), (2.2, 1.0), (3.4, -1.0))


def fit(before, now, truth=HERE):
    """Return the fit of a scan of now to a map of before, and its scatter."""
    matcher = ScanMatcher(CONFIG)
    for x in (-1.5, 0.0, 1.5):
        pose = truth @ SE2(x, 0.0, 0.0)
        matcher.insert(points_of(scan_at(pose, before, range_max=8.0), HERE, CONFIG), pose)
    scan = scan_at(truth, now, rng=np.random.default_rng(4), range_max=8.0)
    points = points_of(scan, HERE, CONFIG)
    match = matcher.match(points, truth, START_COV)
    return match, scatter_of(matcher, points, match.T_map_base, START_COV)


def sigma(cov):
    return float(np.sqrt(np.linalg.eigvalsh(cov[:2, :2]).max()))


def test_where_nothing_moved_all_parts_agree():
    match, scatter = fit(square_room(), square_room())
    assert match.T_map_base.distance < 0.02
    assert scatter.shape == (3, 3) and sigma(scatter) < 0.02


def test_furniture_that_moved_along_a_corridor_is_told_though_the_match_is_sure():
    shifted = moved_walls(SE2(SHIFT_M, 0.0, 0.0), MOVED)
    match, scatter = fit(
        np.vstack((CORRIDOR, STAYED, MOVED)), np.vstack((CORRIDOR, STAYED, shifted))
    )
    assert -SHIFT_M < match.T_map_base.x < -0.2 * SHIFT_M  # pulled, by not all of it
    assert match.weak_direction[0] < MAX_SIGMA_M < sigma(scatter)
    values, axes = np.linalg.eigh(scatter[:2, :2])
    assert abs(axes[0, 1]) > 0.95  # along the corridor
    assert values[0] < 0.02**2


def test_what_nothing_tells_is_no_disagreement():
    _, scatter = fit(CORRIDOR, CORRIDOR)
    assert sigma(scatter) < 0.02


@pytest.mark.parametrize("yaw", [0.5, 2.2])
def test_turning_the_world_turns_the_scatter(yaw):
    T = SE2(0.0, 0.0, yaw)
    before = np.vstack((CORRIDOR, STAYED, MOVED))
    now = np.vstack((CORRIDOR, STAYED, moved_walls(SE2(SHIFT_M, 0.0, 0.0), MOVED)))
    _, turned = fit(moved_walls(T, before), moved_walls(T, now), T)
    assert sigma(turned) > MAX_SIGMA_M
    _, axes = np.linalg.eigh(turned[:2, :2])
    assert abs(axes[:, 1] @ [np.cos(yaw), np.sin(yaw)]) > 0.95
