"""What judges maps of glass, by hand: figures, rays, lengths, paths, the costmap layer."""

import math

import numpy as np
import pytest

from experiments.glass_map import length_spreads, spreads
from experiments.glass_measures import Face, faces_of, fitted, measured
from experiments.glass_metrics import (
    false_occupied,
    phantom_share,
    precision,
    share_found,
    thin,
    wall_error,
)
from experiments.glass_paths import crossings, drivable, plan
from experiments.glass_rays import count_faced, first_hits
from experiments.glass_truth import (
    distance_to_segments,
    lattice_round,
    samples,
    seen_through_glass,
    signed_distance_near,
    thinned,
)
from experiments.range_layer import RangeLayer, sensor_probability
from floornav_common.grid import OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from sim_bridge.glass import Glass
from sim_bridge.measures import Measure
from sim_bridge.solids import Solid

CELL = 0.05


def a_map(rows: int, cols: int, value: int = 0, x: float = 0.0, y: float = 0.0) -> OccupancyMap:
    return OccupancyMap(np.full((rows, cols), value, np.int8), CELL, SE2(x, y, 0.0))


def with_boxes(occupancy: OccupancyMap, *boxes: tuple[float, float, float, float]) -> OccupancyMap:
    """Return a map with the cells whose centers lie in boxes (x0, y0, x1, y1) occupied."""
    cells = occupancy.cells.copy()
    points = occupancy.to_points(np.argwhere(cells == cells))
    for x0, y0, x1, y1 in boxes:
        inside = (points >= (x0, y0)).all(axis=1) & (points <= (x1, y1)).all(axis=1)
        cells.reshape(-1)[inside] = 100
    return OccupancyMap(cells, occupancy.resolution, occupancy.origin)


def box(x0: float, y0: float, x1: float, y1: float, glass: Glass | None = None) -> Solid:
    pose, size = SE2((x0 + x1) / 2.0, (y0 + y1) / 2.0, 0.0), (x1 - x0, y1 - y0, 2.0)
    return Solid("box", pose, size, 0.0, False, (0.5, 0.5, 0.5), glass=glass)


def test_found_is_what_has_an_occupied_center_within_10_cm() -> None:
    points = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.5, 0.0]])
    occupied = np.array([[0.0, 0.10], [0.5, 0.11], [1.05, 0.05]])
    assert share_found(points, occupied) == 0.5
    assert share_found(points, np.zeros((0, 2))) == 0.0
    assert math.isnan(share_found(np.zeros((0, 2)), occupied))


def test_a_bar_is_thinned_to_one_line_of_about_its_length() -> None:
    mask = np.zeros((9, 30), bool)
    mask[3:6, 3:27] = True
    line = thin(mask)
    assert (line.sum(axis=0) <= 1).all()
    assert set(np.nonzero(line)[0]) == {4}
    assert 20 <= line.sum() <= 24


def test_a_line_one_cell_wide_is_thin_already_also_at_the_edge() -> None:
    mask = np.zeros((5, 20), bool)
    mask[0, :] = True
    np.testing.assert_array_equal(thin(mask), mask)


def test_precision_goes_by_length_not_by_thickness() -> None:
    claimed, to_glass = np.zeros((40, 40), bool), np.full((40, 40), 9.0)
    claimed[5, 5:35] = True  # on a pane, thin
    to_glass[3:8] = 0.05
    claimed[20:25, 5:35] = True  # nowhere near, five cells thick
    assert precision(claimed, to_glass) == pytest.approx(0.5, abs=0.06)
    assert math.isnan(precision(np.zeros((4, 4), bool), np.zeros((4, 4))))


def test_false_cells_are_counted_over_known_free_cells_only() -> None:
    cells = np.array([[0, 0, 100, 100, -1, 100]], np.int8)
    to_real = np.array([[9.0, 9.0, 9.0, 0.1, 9.0, 9.0]])
    assert false_occupied(cells, to_real) == 0.5  # two of four: one is at a wall, one unknown


def test_wall_error_is_the_mean_distance_of_walls_cells_to_the_surface() -> None:
    cells = np.array([[100, 100, 100, 100, 0]], np.int8)
    to_opaque = np.array([[0.01, 0.03, 0.02, 0.40, 0.0]])
    to_glass = np.array([[9.0, 9.0, 0.01, 9.0, 9.0]])  # the third is the pane's
    assert wall_error(cells, to_opaque, to_glass) == pytest.approx(0.02)


def test_phantoms_lie_behind_panes_off_everything_real() -> None:
    cells = np.array([[100, 100, 100, 100, 0]], np.int8)
    to_real = np.array([[0.2, 0.05, 0.2, 0.2, 0.2]])
    to_glass = np.array([[0.2, 0.2, 0.12, 0.2, 0.2]])
    is_behind = np.array([[True, True, True, False, True]])
    assert phantom_share(cells, to_real, to_glass, is_behind) == 0.5


def test_distances_and_samples_of_segments() -> None:
    segments = np.array([[0.0, 0.0, 1.0, 0.0]])
    points = np.array([[0.5, 0.2], [1.3, 0.4], [-0.3, 0.0]])
    np.testing.assert_allclose(distance_to_segments(points, segments), [0.2, 0.5, 0.3])
    np.testing.assert_allclose(samples(segments, 0.25)[:, 0], [0.125, 0.375, 0.625, 0.875])
    assert len(samples(np.zeros((0, 4)))) == 0


def test_a_way_is_thinned_by_distance() -> None:
    way = np.column_stack((np.arange(0.0, 1.05, 0.1), np.zeros(11)))
    np.testing.assert_allclose(thinned(way, 0.25)[:, 0], [0.0, 0.3, 0.6, 0.9])


def test_lattice_lies_on_whole_cells_with_a_margin() -> None:
    lattice = lattice_round(np.array([[0.02, 0.0], [2.0, 1.0]]))
    assert (lattice.origin.x, lattice.origin.y) == pytest.approx((-1.0, -1.0))
    assert lattice.cells.shape == (60, 80)


def test_signed_distance_near_solids() -> None:
    lattice = a_map(40, 40)
    distances = signed_distance_near(lattice, [box(0.5, 0.5, 1.0, 1.0)])
    assert distances[15, 15] == pytest.approx(-0.225)  # center at 0.775
    assert distances[15, 25] == pytest.approx(0.275)
    assert np.isinf(distances[39, 39])


def test_rays_end_at_the_nearest_segment() -> None:
    segments = np.array([[2.0, -1.0, 2.0, 1.0], [1.0, -1.0, 1.0, 1.0]])
    rays = np.array([[1.0, 0.0], [-1.0, 0.0]])
    distances, which = first_hits(np.zeros(2), rays, segments)
    np.testing.assert_allclose(distances, [1.0, np.inf])
    assert which.tolist() == [1, -1]


def test_cells_behind_a_pane_are_those_seen_through_it() -> None:
    lattice = a_map(80, 80, x=0.0, y=-2.0)
    panes = np.array([[1.0, -0.5, 1.0, 0.5]])
    wall = np.array([[2.5, -2.0, 2.5, 2.0]])
    seen = seen_through_glass(np.array([[0.1, 0.0]]), wall, panes, lattice)

    def is_seen(x: float, y: float) -> bool:
        return bool(seen[tuple(lattice.to_cells(np.array([[x, y]]))[0])])

    assert is_seen(1.5, 0.0)
    assert is_seen(2.4, 0.5)
    assert not is_seen(0.5, 0.0)  # before it
    assert not is_seen(1.08, 0.0)  # nearer than 15 cm
    assert not is_seen(2.7, 0.0)  # behind the wall
    assert not is_seen(1.5, 1.5)  # beside the pane


def test_cells_far_behind_a_pane_are_behind_it_too() -> None:
    lattice, nothing = a_map(40, 240, x=0.0, y=-1.0), np.zeros((0, 4))
    panes = np.array([[1.0, -0.5, 1.0, 0.5]])
    seen = seen_through_glass(np.array([[0.1, 0.0]]), nothing, panes, lattice)
    cells = lattice.to_cells(np.array([[x, 0.0] for x in np.arange(1.25, 11.9, 0.5)]))
    assert seen[tuple(cells.T)].all()
    assert not seen[:, :20].any()


def test_no_pane_no_cells_behind_it() -> None:
    nothing = seen_through_glass(np.zeros((1, 2)), np.zeros((0, 4)), np.zeros((0, 4)), a_map(4, 4))
    assert not nothing.any()


@pytest.mark.parametrize(
    ("sonar", "blockers", "count"),
    [
        ((0.0, 0.0, 0.0), [], 1),
        ((0.0, 0.0, math.radians(9.0)), [], 1),
        ((0.0, 0.0, math.radians(11.0)), [], 0),  # out of the cone
        ((0.0, 0.4, math.radians(-22.0)), [], 0),  # the pane at a slant
        ((-5.0, 0.0, 0.0), [], 0),  # out of reach
        ((0.0, 0.0, 0.0), [[0.5, -1.0, 0.5, 1.0]], 0),  # hidden
    ],
)
def test_a_sonar_faces_glass_within_cone_angle_and_reach(sonar, blockers, count) -> None:
    pane = [1.0, -1.0, 1.0, 1.0]
    found = count_faced(
        np.array([sonar]), np.array([[1.0, 0.0]]), np.array([[1.0, 0.0]]),
        np.array([pane, *blockers]), math.radians(10.0), 5.0, math.radians(15.0), 0.03,
    )  # fmt: skip
    assert found.tolist() == [count]


ROOM = [
    box(-0.1, 0.0, 0.0, 2.0), box(3.0, 0.0, 3.1, 2.0), box(0.0, -0.1, 3.0, 0.0),
    box(0.0, 2.0, 3.0, 2.01, Glass(thickness_m=0.01)), box(0.97, 0.97, 1.03, 1.03),
]  # fmt: skip
ROOM_MAP = with_boxes(
    a_map(50, 70, x=-0.2, y=-0.2),
    (-0.05, 0.0, 0.05, 2.0), (2.95, 0.0, 3.05, 2.0), (0.0, -0.05, 3.0, 0.05),
    (0.0, 1.95, 3.0, 2.05), (0.95, 0.95, 1.05, 1.05),
)  # fmt: skip


@pytest.mark.parametrize(
    ("measure", "value"),
    [
        (Measure(name="width", from_m=(0.0, 1.5), to_m=(3.0, 1.5)), 3.0),
        (Measure(name="depth", from_m=(1.5, 0.0), to_m=(1.5, 2.0)), 2.0),
        (Measure(name="corner", from_m=(0.0, 1.5), corner_m=(0.0, 0.0), to_m=(1.5, 0.0)), 90.0),
        (Measure(name="to post", from_m=(0.0, 1.0), to_m=(1.0, 1.0)), 1.0),
    ],
)
def test_lengths_and_angles_of_a_drawn_room(measure: Measure, value: float) -> None:
    assert measured(measure, ROOM, ROOM_MAP, None) == pytest.approx(value, abs=1e-6)


def test_a_length_moves_with_the_wall_in_the_map() -> None:
    off = with_boxes(a_map(50, 70, x=-0.2, y=-0.2), (-0.05, 0.0, 0.05, 2.0), (3.0, 0.0, 3.1, 2.0))
    measure = Measure(name="width", from_m=(0.0, 1.5), to_m=(3.0, 1.5))
    assert measured(measure, ROOM, off, None) == pytest.approx(3.05, abs=1e-6)


def test_what_is_not_in_the_map_has_no_length() -> None:
    measure = Measure(name="width", from_m=(0.0, 1.5), to_m=(3.0, 1.5))
    assert measured(measure, ROOM, a_map(50, 70, x=-0.2, y=-0.2), None) is None


def test_cells_called_glass_are_no_part_of_walls_but_of_panes() -> None:
    glass = OccupancyMap(ROOM_MAP.cells.copy(), CELL, ROOM_MAP.origin)
    width = Measure(name="width", from_m=(0.0, 1.5), to_m=(3.0, 1.5))
    assert measured(width, ROOM, ROOM_MAP, glass) is None
    (_, pane) = faces_of(Measure(name="depth", from_m=(1.5, 0.0), to_m=(1.5, 2.0)), ROOM)
    assert pane.is_glass
    assert pane.length == pytest.approx(3.0)


def test_a_line_leaves_out_what_stands_off_it() -> None:
    face = Face(np.zeros(2), np.array((2.0, 0.0)), is_glass=False)
    along = np.arange(0.125, 1.9, 0.05)
    wall = np.column_stack((along, np.full(len(along), 0.01)))
    line = fitted(face, np.vstack((wall, [[1.8, 0.11]])))
    assert line is not None
    assert line.mean[1] == pytest.approx(0.01, abs=1e-9)


def test_measures_need_a_surface() -> None:
    with pytest.raises(ValueError, match="no surface"):
        faces_of(Measure(name="x", from_m=(0.5, 0.5), to_m=(1.5, 0.5)), ROOM)


def corridor(gap: tuple[float, float] | None) -> OccupancyMap:
    """Return 3 x 2 m of free floor with a wall at x = 1.5 m, open where `gap` says."""
    boxes = [(1.5, 0.0, 1.55, 2.0)]
    if gap is not None:
        boxes = [(1.5, 0.0, 1.55, gap[0]), (1.5, gap[1], 1.55, 2.0)]
    return with_boxes(a_map(40, 60), *boxes)


START, GOAL = np.array((0.6, 0.5)), np.array((2.5, 0.5))


def test_a_path_goes_through_a_gap_wide_enough_and_no_other() -> None:
    wide, narrow = corridor((1.0, 1.8)), corridor((1.0, 1.5))
    path = plan(wide, drivable(wide), START, GOAL)
    assert path is not None
    np.testing.assert_allclose(path[[0, -1]], [START, GOAL], atol=CELL)
    crossing = path[np.abs(path[:, 0] - 1.5).argmin()]
    assert 1.3 - CELL <= crossing[1] <= 1.5 + CELL
    assert plan(narrow, drivable(narrow), START, GOAL) is None


def test_a_free_way_is_as_short_as_steps_to_8_neighbors_can_be() -> None:
    free = a_map(40, 60)
    path = plan(free, drivable(free), np.array((0.525, 0.525)), np.array((1.525, 0.825)))
    assert path is not None
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    assert length == pytest.approx(CELL * (14 + 6 * math.sqrt(2.0)))


def test_unknown_cells_are_not_driven() -> None:
    occupancy = a_map(40, 60)
    occupancy.cells[:, 30] = -1
    assert plan(occupancy, drivable(occupancy), START, GOAL) is None


def test_a_goal_in_a_wall_is_moved_only_so_far() -> None:
    solid = with_boxes(a_map(40, 60), (1.5, 0.0, 3.0, 2.0))
    can_drive = drivable(solid)
    assert plan(solid, can_drive, START, np.array((1.6, 0.5))) is not None
    assert plan(solid, can_drive, START, GOAL) is None
    assert plan(solid, can_drive, START, np.array((-9.0, 0.5))) is None


def test_crossings_of_a_path_with_panes() -> None:
    path = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    panes = np.array([[1.5, -1.0, 1.5, 1.0], [0.5, 0.5, 0.5, 1.0], [0.0, 1.0, 2.0, 1.0]])
    np.testing.assert_allclose(crossings(path, panes), [[1.5, 0.0]])
    assert len(crossings(path[:1], panes)) == 0


def reading(range_m: float) -> RangeReading:
    return RangeReading(range_m, math.radians(20.0), 0.15, 5.0)


def test_the_costmap_layer_raises_the_arc_and_lowers_what_is_before() -> None:
    half = math.radians(10.0)
    assert sensor_probability(1.0, 1.0, 0.0, half) > 0.75
    assert sensor_probability(1.0, 0.5, 0.0, half) < 0.15
    assert sensor_probability(1.0, 1.2, 0.0, half) == 0.5
    assert sensor_probability(1.0, 1.0, half, half) == 0.5
    on_axis, beside = (sensor_probability(1.0, 1.0, a, half) for a in (0.0, 0.8 * half))
    assert on_axis > beside > 0.5
    assert sensor_probability(4.0, 4.0, 0.0, half) < 0.51  # far echoes hardly count


def test_the_costmap_layer_marks_what_is_heard_twice_and_keeps_the_higher_value() -> None:
    laser = a_map(40, 60)
    laser.cells[0, 0], laser.cells[1, 0] = 100, -1
    layer = RangeLayer(laser)
    sonar = SE2(0.5, 1.0, 0.0)
    layer.add_range(reading(math.inf), sonar)
    assert (layer.cells() == -1).all()
    for _ in range(2):
        layer.add_range(reading(1.0), sonar)
    both = layer.combined(laser)
    assert both.cells[20, 30] == 100  # 1.525, 1.025: on the arc
    assert both.cells[20, 20] == 0
    assert (both.cells[0, 0], both.cells[1, 0]) == (100, -1)


def test_the_costmap_layer_can_change_its_mind() -> None:
    layer = RangeLayer(a_map(40, 60))
    for _ in range(100):
        layer.add_range(reading(1.0), SE2(0.5, 1.0, 0.0))
    for _ in range(10):
        layer.add_range(reading(1.9), SE2(0.5, 1.0, 0.0))
    assert layer.cells()[20, 30] == 0


def figures(recall: float) -> dict[str, float]:
    return {
        "glass_recall": recall, "glass_precision": math.nan, "glass_seen_share": 1.0,
        "false_occupied": 1.0 - recall, "wall_error_m": 0.02, "phantom_share": 0.0,
    }  # fmt: skip


def test_spreads_name_mean_median_and_worst_floor() -> None:
    floors = [
        {"world": name, "icp": {"overlay": figures(recall), "bayes": None}}
        for name, recall in (("one", 0.5), ("two", 1.0), ("three", 0.9))
    ]
    found = spreads(floors, "icp")
    assert found["bayes"] is None
    row = found["overlay"]
    assert row is not None
    assert row["glass_recall"] == pytest.approx(0.8)
    assert (row["glass_recall_median"], row["glass_recall_worst"]) == (0.9, 0.5)
    assert row["glass_recall_worst_in"] == "one"
    assert (row["false_occupied_worst"], row["false_occupied_worst_in"]) == (0.5, "one")
    assert row["glass_precision"] is None


def test_errors_of_lengths_are_summed_up_over_seeds_by_row_and_turn() -> None:
    like = {"experiment": 1, "name": "a", "what": "width", "unit": "m", "true": 2.0}
    entries = [
        {**like, "method": "bayes", "turn_rad": 0.0, "seed": k, "error": error}
        for k, error in enumerate((0.03, -0.04, None))
    ]
    entries.append({**like, "method": "bayes", "turn_rad": 0.3, "seed": 0, "error": None})
    straight, turned = length_spreads(entries)
    assert (straight["seeds"], straight["in_map"]) == (3, 2)
    assert straight["error_rms"] == pytest.approx(math.sqrt(0.0025 / 2.0))
    assert straight["error_worst"] == -0.04
    assert (turned["turn_rad"], turned["in_map"], turned["error_worst"]) == (0.3, 0, None)
