import numpy as np
import pytest

from experiments.slam import fill, spreads
from experiments.slam_drives import LAPS, ROBOT, floor_names, peopled
from experiments.slam_false_loops import FAR_M, FalseLoops
from experiments.slam_measures import tolerant_iou
from experiments.slam_runs import FIGURES, METHODS
from floornav_common.se2 import SE2
from sim_bridge.world import load_world


def line(col, rows=20, cols=12):
    mask = np.zeros((rows, cols), bool)
    mask[:, col] = True
    return mask


def test_the_same_walls_and_walls_a_cell_beside_count_as_one():
    assert tolerant_iou(line(4), line(4)) == 1.0
    assert tolerant_iou(line(4), line(5)) == 1.0


def test_walls_two_cells_off_share_nothing():
    assert tolerant_iou(line(4), line(6)) == 0.0
    assert tolerant_iou(line(4), np.zeros((20, 12), bool)) == 0.0


def test_half_of_a_wall_found_is_a_half():
    half = line(4)
    half[10:] = False
    # One more row of the wall lies within a cell of the half: I = (10 + 11) / 2.
    assert tolerant_iou(half, line(4)) == pytest.approx(10.5 / (10 + 20 - 10.5))


def test_floors_are_rings_and_another_seed_has_others():
    names = floor_names(4)
    assert len(set(names)) == 4 and names == floor_names(6)[:4]
    assert not set(names) & set(floor_names(4, seed=1))


def test_people_walk_in_both_corridors_on_free_floor_and_the_route_is_driven_twice():
    for name in floor_names(6):
        plain = load_world(name)
        world = peopled(plain, 3)
        assert len(world.people) == 4
        assert len({round(p.path_m[0][1]) for p in world.people}) >= 2
        assert world.route.waypoints_m == LAPS * plain.route.waypoints_m
        assert world.robots[0].overrides["wheels"] == ROBOT["wheels"]
        ys = [wall.from_m[1] for wall in world.walls if wall.from_m[1] == wall.to_m[1]]
        for person in world.people:
            y = person.path_m[0][1]
            assert person.path_m[1][1] == y and min(abs(y - wall) for wall in ys) > 0.3


class Frame:
    def __init__(self, stamp_ns):
        self.stamp_ns = stamp_ns


class Closer:
    def __init__(self, truth):
        self.poses, self.edges = list(truth), []
        self.frames = [Frame(k) for k in range(len(truth))]
        self.num_solved = 0

    def solve(self):
        self.num_solved += 1


def test_wrong_loops_are_wrong_and_come_at_their_share_of_the_drive():
    truth = [SE2(10.0 * np.cos(a), 10.0 * np.sin(a), a) for a in np.linspace(0.0, 9.0, 200)]
    wrong = FalseLoops(truth, np.arange(200), np.random.default_rng(0))
    closer = Closer(truth)
    for k in range(200):
        wrong.slip_in(closer, (k + 1) / 200)
    assert wrong.num == 4 and closer.num_solved == 3
    for edge in closer.edges:
        off = edge.T_first_second.between(truth[edge.first].between(truth[edge.second]))
        assert off.distance > 0.9
    far = closer.edges[0]
    assert truth[far.first].between(truth[far.second]).distance > FAR_M
    a, b = closer.edges[2:]
    said = a.T_first_second.inverse() @ b.T_first_second
    chain = truth[a.second].between(truth[b.second])
    assert said.between(chain).distance < 1e-9
    closer.edges = closer.edges[1:]
    assert wrong.num_kept(closer) == 3


def result(world, **figures):
    rows = {m: dict.fromkeys(FIGURES, 1.0) for m in METHODS}
    rows["after"] |= figures
    counts = {"false_loops_found": 1, "false_loops_injected": 4, "false_loops_kept": 2}
    return {"world": world, "methods": rows, "loops": 5, **counts}


def test_the_summary_has_medians_quartiles_and_the_worst_floor():
    results = [result(str(k), ate_m=float(k), map_iou=float(k)) for k in range(5)]
    results[0]["methods"]["after"]["glass_recall"] = float("nan")
    row = spreads(results, "after")
    assert (row["ate_m"], row["ate_m_low"], row["ate_m_high"]) == (2.0, 1.0, 3.0)
    assert (row["ate_m_worst_in"], row["map_iou_worst_in"]) == ("4", "0")
    assert row["glass_recall"] == 1.0
    values = {}
    fill(values, results)
    assert values["false_loops_accepted"] == 5 * 3
    fill(values, [])
    assert values["methods"]["after"]["ate_m"] is None
