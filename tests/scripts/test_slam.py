from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from experiments import consistency
from experiments.slam import fill, spreads
from experiments.slam_drives import LAPS, ROBOT, floor_names, peopled
from experiments.slam_false_loops import APART_NODES, BACK_M, BACK_NODES, FAR_M, FalseLoops
from experiments.slam_measures import tolerant_iou
from experiments.slam_runs import FIGURES, METHODS, num_false, spun_s
from floornav_common.se2 import SE2
from grid_mapper.key_frames import Edge
from sim_bridge.world import load_world

TURN = 2.0 * np.pi


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


def test_wheels_spin_where_odometry_runs_ahead_of_the_truth_and_not_where_a_wheel_is_a_little_off():
    stamps_ns = np.arange(5) * 500_000_000
    truth = np.array([(x, 0.0, 0.0) for x in (0.0, 0.5, 1.0, 1.0, 1.0)])
    odometry = np.array([(x, 0.0, 0.0) for x in (0.0, 0.51, 1.02, 1.32, 1.62)])
    assert spun_s(stamps_ns, odometry, truth) == pytest.approx(1.0)
    assert spun_s(stamps_ns, truth, truth) == 0.0


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


def drive_with_wrong_loops(laps):
    """Return the wrong loops of a drive round a circle of 63 m, and at which node each came."""
    truth = [SE2(10.0 * np.cos(a), 10.0 * np.sin(a), a) for a in np.linspace(0.0, laps * TURN, 400)]
    wrong = FalseLoops(truth, np.arange(400), np.random.default_rng(0))
    closer, came = Closer([]), []
    for k in range(400):
        closer.poses.append(truth[k])
        closer.frames.append(Frame(k))
        num = wrong.num
        wrong.slip_in(closer, (k + 1) / 400)
        came += (wrong.num - num) * [k]
    return truth, wrong, closer, came


def off_of(edge, truth):
    return edge.T_first_second.between(truth[edge.first].between(truth[edge.second]))


def test_wrong_loops_are_wrong_and_come_at_their_share_of_the_drive():
    truth, wrong, closer, came = drive_with_wrong_loops(2)
    (first,) = {k for k in came if k not in (159, 239, 279, 319)}
    assert wrong.num == 6 and closer.num_solved == 5
    assert sorted(came) == sorted([159, first, 239, 279, 319, 319])
    by_node = {edge.second: edge for edge in closer.edges}
    sizes = {k: off_of(by_node[k], truth).distance for k in (first, 239, 279)}
    assert sizes == {k: pytest.approx(m) for k, m in ((first, 0.5), (239, 1.0), (279, 0.5))}
    far = by_node[159]
    assert truth[far.first].between(truth[far.second]).distance > FAR_M
    a, b = (edge for edge in closer.edges if edge.second in (319, 319 - APART_NODES))
    said = a.T_first_second.inverse() @ b.T_first_second
    chain = truth[a.second].between(truth[b.second])
    assert said.between(chain).distance < 1e-9
    closer.edges = closer.edges[1:]
    assert wrong.num_kept(closer) == 5 and not wrong.is_made(replace(far))


def test_the_first_wrong_loop_comes_where_the_robot_is_back_for_the_first_time():
    truth, wrong, closer, came = drive_with_wrong_loops(2)
    first = next(k for k in came if k not in (159, 239, 279, 319))
    away = [truth[k].between(truth[first]).distance for k in range(first - BACK_NODES)]
    assert min(away) < BACK_M and wrong.num_loops_before == closer.edges.index(
        next(edge for edge in closer.edges if edge.second == first)
    )
    before = [truth[k].between(truth[first - 1]).distance for k in range(first - 1 - BACK_NODES)]
    assert min(before) >= BACK_M
    _, alone, _, _ = drive_with_wrong_loops(0.9)
    assert alone.num == 5 and alone.num_loops_before is None


def test_loops_that_a_spoiled_graph_closes_wrongly_itself_count_without_those_slipped_in():
    truth, wrong, closer, _ = drive_with_wrong_loops(2)
    log = SimpleNamespace(scan_ns=np.arange(400))
    assert num_false(closer, truth, log, wrong) == 0
    assert num_false(closer, truth, log) == 6
    right = truth[3].between(truth[200])
    closer.edges.append(Edge(3, 200, right, np.eye(3), is_loop=True))
    closer.edges.append(Edge(3, 200, right @ SE2(0.4, 0.0, 0.0), np.eye(3), is_loop=True))
    assert num_false(closer, truth, log, wrong) == 1


def result(world, **figures):
    rows = {m: dict.fromkeys(FIGURES, 1.0) for m in METHODS}
    rows["after"] |= figures
    counts = {"found": 1, "injected": 6, "kept": 2, "led_to": 3}
    nees = {kind: consistency.figures(np.full(4, 3.0), 4) for kind in consistency.KINDS}
    counted = {f"false_loops_{count}": num for count, num in counts.items()}
    return {"world": world, "methods": rows, "loops": 5, "nees": nees, **counted}


def test_the_summary_has_medians_quartiles_and_the_worst_floor():
    results = [result(str(k), ate_m=float(k), map_iou=float(k)) for k in range(5)]
    results[0]["methods"]["after"]["glass_recall"] = float("nan")
    row = spreads(results, "after")
    assert (row["ate_m"], row["ate_m_low"], row["ate_m_high"]) == (2.0, 1.0, 3.0)
    assert (row["ate_m_worst_in"], row["map_iou_worst_in"]) == ("4", "0")
    assert row["glass_recall"] == 1.0
    values = {}
    fill(values, results)
    assert values["false_loops_accepted"] == 5 * (1 + 2 + 3)
    assert values["nees"]["loops"]["num"] == 20 and values["nees"]["loops"]["mean"] == 3.0
    fill(values, [])
    assert values["methods"]["after"]["ate_m"] is None
