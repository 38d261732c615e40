"""Panes on the map, from scans and readings of drives in worlds of a few straight surfaces."""

import numpy as np
import pytest

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.bayes_fusion import BayesFusion
from grid_mapper.bayes_moment import on_panes
from grid_mapper.config import GridMapperConfig

UP, HALF, REACH = np.pi / 2.0, np.deg2rad(10.0), 5.0
ANGLES = np.deg2rad(np.arange(-180.0, 180.0, 0.5))
ROOM = [
    (-2.0, -1.0, 6.0, -1.0),
    (6.0, -1.0, 6.0, 4.0),
    (6.0, 4.0, -2.0, 4.0),
    (-2.0, 4.0, -2.0, -1.0),
]
PANE = (0.0, 1.52, 3.0, 1.52)
TOL_M = 0.04
EMPTY = OccupancyMap(np.zeros((120, 180), np.int8), 0.05, SE2(-2.5, -1.5, 0.0))


def distances(pose, angles, surfaces):
    """Return the distance of the first surface in each direction, and the angle it is met at."""
    best, slant = np.full(len(angles), np.inf), np.full(len(angles), np.inf)
    u = np.column_stack((np.cos(angles), np.sin(angles)))
    for x0, y0, x1, y1 in surfaces:
        way, to = np.array([x1 - x0, y1 - y0]), np.array([x0 - pose.x, y0 - pose.y])
        cross = u[:, 0] * way[1] - u[:, 1] * way[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (to[0] * way[1] - to[1] * way[0]) / cross
            s = (to[0] * u[:, 1] - to[1] * u[:, 0]) / cross
        is_hit = (t > 0.0) & (s >= 0.0) & (s <= 1.0) & (t < best)
        best[is_hit] = t[is_hit]
        slant[is_hit] = np.arccos(np.minimum(np.abs(cross) / np.hypot(*way), 1.0))[is_hit]
    return best, slant


def echo(pose, surfaces):
    """Return the range of the first surface that answers a sonar within 15 degrees, else inf."""
    r, slant = distances(pose, pose.yaw + np.linspace(-HALF, HALF, 41), surfaces)
    return float(np.min(r[slant <= np.deg2rad(15.0)], initial=np.inf))


def drive(fusion, poses, opaque, glass, yaws=(UP, -UP), start_s=0):
    """Feed what a laser and sonars would measure from poses, half a second apart."""
    for k, pose in enumerate(poses):
        stamp = round((start_s + 0.5 * k) * 1e9)
        r, _ = distances(pose, pose.yaw + ANGLES, opaque)
        scan = Scan(r, float(ANGLES[0]), float(np.deg2rad(0.5)), 0.05, 10.0)
        fusion.add_scan(scan, pose, stamp)
        for yaw in yaws:
            sonar = SE2(pose.x, pose.y, pose.yaw + yaw)
            heard = echo(sonar, [*opaque, *glass])
            heard = heard if heard < REACH else np.inf
            fusion.add_range(RangeReading(heard, 2 * HALF, 0.1, REACH), sonar, stamp)


def along(y=0.0, low=-0.5, high=3.5, yaw=0.0):
    return [SE2(float(x), y, yaw) for x in np.arange(low, high, 0.08)]


def mapped(*args, **kwargs):
    fusion = BayesFusion(GridMapperConfig(fusion="bayes"))
    drive(fusion, *args, **kwargs)
    return fusion


def occupied(fusion):
    """Return the centers of occupied cells, (N, 2)."""
    cells = fusion.occupancy(EMPTY)
    return cells.to_points(np.argwhere(cells.cells >= 50))


def test_a_pane_that_the_laser_looks_through_is_a_thin_wall_in_its_place():
    points = occupied(mapped(along(), ROOM, [PANE]))
    assert np.abs(points[:, 1] - 1.52).max() <= TOL_M
    assert points[:, 0].min() == pytest.approx(0.0, abs=0.25)
    assert points[:, 0].max() == pytest.approx(3.0, abs=0.25)
    columns = np.unique(np.round(points[:, 0], 3))
    assert np.diff(columns).max() < 0.06  # no hole


def test_the_glass_layer_says_the_same():
    glass = mapped(along(), ROOM, [PANE]).glass()
    assert set(np.unique(glass.cells)) == {UNKNOWN, OCCUPIED}
    points = glass.to_points(np.argwhere(glass.cells == OCCUPIED))
    assert np.abs(points[:, 1] - 1.52).max() <= TOL_M


def test_a_room_without_glass_has_none():
    pillar = (1.0, 1.5, 1.4, 1.5)  # its echoes are explained by what the laser sees
    assert len(mapped(along(), [*ROOM, pillar], []).panes()) == 0


def test_a_pane_seen_from_both_sides_is_one_thin_wall():
    fusion = mapped(along(), ROOM, [PANE])
    drive(fusion, along(y=2.8), ROOM, [PANE], start_s=100)
    points = occupied(fusion)
    assert np.abs(points[:, 1] - 1.52).max() <= TOL_M


def slanted_echoes(fusion):
    """Feed echoes from the line n . p = 2.4, 26 degrees off the pane's normal and behind it."""
    yaw = UP + 0.45
    for k, x in enumerate(np.arange(0.9, 2.8, 0.05)):
        reading = RangeReading(float(2.4 - np.cos(yaw) * x), 2 * HALF, 0.1, REACH)
        fusion.add_range(reading, SE2(float(x), 0.0, yaw), round((50 + k) * 1e9))


def test_nothing_is_drawn_behind_a_pane_where_sound_comes_by_mirrors():
    alone = BayesFusion(GridMapperConfig(fusion="bayes"))
    slanted_echoes(alone)
    assert len(alone.panes()) > 0  # without the pane before it that would be one
    fusion = mapped(along(), ROOM, [PANE])
    slanted_echoes(fusion)
    assert np.abs(occupied(fusion)[:, 1] - 1.52).max() <= TOL_M


def test_glass_that_was_taken_away_is_cleared():
    fusion = mapped(along(), ROOM, [PANE])
    drive(fusion, along(y=-0.1), ROOM, [], start_s=100)
    assert len(fusion.panes()) == 0


@pytest.mark.parametrize("y", [1.41, 1.62])
def test_a_way_close_beside_a_pane_keeps_it(y):
    fusion = mapped(along(), ROOM, [PANE])
    before = np.ptp(fusion.panes()[:, [0, 2]])
    drive(fusion, along(y=y), ROOM, [PANE], yaws=(0.0, UP, -UP), start_s=100)
    assert np.ptp(fusion.panes()[:, [0, 2]]) >= before - 0.2


def test_a_glass_door_that_is_shut_later_is_mapped():
    beside = [(0.0, 1.52, 1.2, 1.52), (2.4, 1.52, 3.6, 1.52)]
    fusion = BayesFusion(GridMapperConfig(fusion="bayes"))
    for k, y in enumerate((0.0, 0.2)):
        drive(fusion, along(y=y), ROOM, beside, start_s=100 * k)
    assert not any((occupied(fusion)[:, 0] > 1.45) & (occupied(fusion)[:, 0] < 2.15))
    for k, y in enumerate((-0.1, 0.3)):
        drive(fusion, along(y=y), ROOM, [(0.0, 1.52, 3.6, 1.52)], start_s=300 + 100 * k)
    points = occupied(fusion)
    columns = np.unique(points[(points[:, 0] > 0.9) & (points[:, 0] < 2.7), 0])
    assert np.diff(columns).max() < 0.06  # no hole


def test_one_silent_pass_from_afar_leaves_a_mapped_pane():
    pane = (0.0, 2.3, 3.0, 2.3)
    fusion = BayesFusion(GridMapperConfig(fusion="bayes"))
    for k, y in enumerate((0.6, 0.8)):
        drive(fusion, along(y=y), ROOM, [pane], start_s=100 * k)
    before = np.ptp(fusion.panes()[:, [0, 2]])
    drive(fusion, along(), ROOM, [], start_s=300)
    assert np.ptp(fusion.panes()[:, [0, 2]]) == pytest.approx(before, abs=0.1)


def test_a_low_box_that_the_laser_looks_over_is_an_obstacle_too():
    box = (1.0, 1.0, 1.8, 1.0)
    points = occupied(mapped(along(), ROOM, [box]))
    assert np.abs(points[:, 1] - 1.0).max() <= TOL_M
    assert np.ptp(points[:, 0]) == pytest.approx(0.8, abs=0.35)


def test_a_doorway_between_panes_stays_open():
    left, right = (0.0, 1.52, 1.2, 1.52), (2.4, 1.52, 3.5, 1.52)
    points = occupied(mapped(along(), ROOM, [left, right]))
    # Without a frame an edge is known as well as the cone is narrow: 0.27 m at this distance.
    assert not ((points[:, 0] > 1.45) & (points[:, 0] < 2.15)).any()
    assert ((points[:, 0] < 1.2).any(), (points[:, 0] > 2.4).any()) == (True, True)


def test_posts_join_panes():
    posts = [(x, 1.5, x + 0.05, 1.5) for x in (0.95, 1.95)]
    panes = [(0.0, 1.52, 0.95, 1.52), (1.0, 1.52, 1.95, 1.52), (2.0, 1.52, 3.0, 1.52)]
    fusion = mapped(along(), [*ROOM, *posts], panes)
    spans = np.sort(np.abs(fusion.panes()[:, [0, 2]]), axis=1)
    spans = spans[np.argsort(spans[:, 0])]
    for (_, end), (start, _) in zip(spans[:-1], spans[1:], strict=True):
        assert start - end <= 0.2  # a post's width and the cells it fills


def test_a_bay_that_no_sonar_faced_between_posts_on_a_panes_line_is_not_free():
    """The robot passes the first bay alone; the laser sees the posts of the next ones."""
    posts = [box(x, 1.52) for x in (1.2, 2.4, 3.6)]
    panes = [(0.0, 1.52, 1.2, 1.52), (1.2, 1.52, 3.6, 1.52)]
    surfaces = [*ROOM, *(side for post in posts for side in post)]
    fusion = mapped(along(low=-0.5, high=0.9), surfaces, panes)
    like = OccupancyMap(EMPTY.cells, EMPTY.resolution, EMPTY.origin)
    cells = fusion.occupancy(like)
    line = [cell_near(cells, x, 1.52) for x in (0.5, 1.8, 3.0)]
    assert line == [OCCUPIED, UNKNOWN, UNKNOWN]
    assert cell_near(fusion.glass(), 1.8, 1.52) == UNKNOWN
    driven = [SE2(1.8, float(y), UP) for y in np.arange(0.2, 3.0, 0.08)]
    drive(fusion, driven, surfaces, panes[:1], start_s=50)  # that bay was a door
    assert cell_near(fusion.occupancy(like), 1.8, 1.52) == FREE


def box(x, y, half=0.05):
    """Return the sides of a post."""
    low, high = (x - half, y - half), (x + half, y + half)
    return [(low[0], low[1], high[0], low[1]), (high[0], low[1], high[0], high[1]),
            (high[0], high[1], low[0], high[1]), (low[0], high[1], low[0], low[1])]  # fmt: skip


def cell_near(grid, x, y):
    """Return the cell at a place, or of those a cell above and below it one that is not free."""
    near = np.array([[x, y + d] for d in (-0.05, 0.0, 0.05)])
    values = [int(grid.cells[r, c]) for r, c in grid.to_cells(near)]
    return next((v for v in values if v != FREE), FREE)


def test_the_glass_layer_claims_nothing_that_the_laser_sees(monkeypatch):
    moment = mapped(along(), ROOM, []).frozen()
    monkeypatch.setattr(moment, "panes", lambda: np.array([(0.0, -1.025, 3.0, -1.025)]))
    wall = moment.glass()
    monkeypatch.setattr(moment, "panes", lambda: np.array([(0.0, 1.525, 3.0, 1.525)]))
    assert int((wall.cells == OCCUPIED).sum()) == 0
    assert int((moment.glass().cells == OCCUPIED).sum()) == pytest.approx(60, abs=2)


@pytest.mark.parametrize("scan_s", [0.5, 100.0])
def test_what_the_laser_sees_later_explains_echoes_heard_before(scan_s):
    fusion = BayesFusion(GridMapperConfig(fusion="bayes"))
    for pose in along(low=-1.5, high=5.5):
        for yaw in (UP, -UP):
            sonar = SE2(pose.x, pose.y, yaw)
            fusion.add_range(RangeReading(echo(sonar, ROOM), 2 * HALF, 0.1, REACH), sonar, 0)
    assert len(fusion.panes()) > 0  # nothing else is known yet
    for k in range(2):
        pose = SE2(2.0 + k, 0.0, 0.0)
        r, _ = distances(pose, ANGLES, ROOM)
        scan = Scan(r, float(ANGLES[0]), float(np.deg2rad(0.5)), 0.05, 10.0)
        fusion.add_scan(scan, pose, round((scan_s + k) * 1e9))
    assert len(fusion.panes()) == 0


def test_moving_robot_and_world_together_moves_the_panes():
    T = SE2(3.0, -1.0, 0.7)
    moved = [[*(T @ np.reshape(w, (2, 2))).ravel()] for w in [*ROOM, PANE]]
    there = mapped([T @ pose for pose in along()], moved[:-1], moved[-1:]).panes()
    ends = (T.inverse() @ there.reshape(-1, 2)).reshape(-1, 2)
    assert np.abs(ends[:, 1] - 1.52).max() <= TOL_M
    assert np.ptp(ends[:, 0]) == pytest.approx(3.0, abs=0.5)


def test_the_same_input_gives_the_same_map_and_a_standing_robot_adds_nothing():
    one, other = mapped(along(), ROOM, [PANE]), mapped(along(), ROOM, [PANE])
    assert np.array_equal(one.panes(), other.panes())
    drive(other, [SE2(1.0, 0.0, 0.0)] * 50, ROOM, [PANE], start_s=100)
    before = other.num_bytes
    drive(other, [SE2(1.0, 0.0, 0.0)] * 500, ROOM, [PANE], start_s=200)
    assert other.num_bytes == before
    assert np.abs(occupied(other)[:, 1] - 1.52).max() <= TOL_M


def test_readings_that_say_nothing_change_nothing():
    fusion = BayesFusion(GridMapperConfig(fusion="bayes"))
    for r in (np.nan, -np.inf, 0.0, 9.0):
        fusion.add_range(RangeReading(r, 2 * HALF, 0.1, REACH), SE2.identity(), 0)
    assert fusion.glass().cells.size == 0
    assert fusion.occupancy(EMPTY).cells.max() == FREE


def test_a_fixed_distance_ranger_tells_of_no_line():
    fusion = BayesFusion(GridMapperConfig(fusion="bayes"))
    drive(fusion, along(), ROOM, [])
    for k, pose in enumerate(along()):
        sonar = SE2(pose.x, pose.y, UP)
        fusion.add_range(RangeReading(-np.inf, 2 * HALF, 1.5, 1.5), sonar, round((50 + k) * 1e9))
    assert len(fusion.panes()) == 0


@pytest.mark.parametrize(("y", "rows"), [(0.025, 1), (0.05, 2), (0.04, 2), (0.03, 1)])
def test_a_pane_is_one_cell_thick_or_two_where_it_lies_on_their_border(y, rows):
    like = OccupancyMap(np.zeros((10, 10), np.int8), 0.05, SE2(0.0, -0.25, 0.0))
    is_on = on_panes(like, np.array([[0.0, y, 0.5, y]]), 0.0375)
    assert int(is_on.any(axis=1).sum()) == rows
    assert is_on.any(axis=0).all()
