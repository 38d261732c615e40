import sys

import numpy as np
import pytest
from loop_builders import LOOSE, SURE, largest_error, motion

from floornav_common.se2 import SE2
from grid_mapper.pose_graph import (
    QUICK_TOLERANCE,
    GraphSolver,
    deviations,
    deviations_of,
    load_solver,
    solve,
)

KERNEL = 2.0
TOL_M = 1e-4


def square(num=8, side=4.0):
    """Return true poses round a square, the last where the first is, and their motions."""
    per = num // 4
    step = SE2(side / per, 0.0, 0.0)
    poses = [SE2.identity()]
    for k in range(num):
        turn = SE2(0.0, 0.0, np.pi / 2.0 if (k + 1) % per == 0 else 0.0)
        poses.append(poses[-1] @ step @ turn)
    return poses


def chain(poses):
    return [
        motion(k, k + 1, a.between(b))
        for k, (a, b) in enumerate(zip(poses, poses[1:], strict=False))
    ]


def drifting(edges, turn):
    moved = [
        SE2(e.T_first_second.x, e.T_first_second.y, e.T_first_second.yaw + turn) for e in edges
    ]
    return [motion(e.first, e.second, T) for e, T in zip(edges, moved, strict=True)]


def along(edges):
    poses = [SE2.identity()]
    for edge in edges:
        poses.append(poses[-1] @ edge.T_first_second)
    return poses


def test_a_loop_of_two_equal_halves_meets_in_the_middle():
    edges = [motion(0, 1, SE2(1.0, 0.0, 0.0)), motion(0, 1, SE2(1.2, 0.0, 0.0))]
    poses = solve([SE2.identity(), SE2(1.0, 0.0, 0.0)], edges, KERNEL)
    assert poses[1].x == pytest.approx(1.1, abs=TOL_M)


def test_the_first_node_stays():
    start = SE2(3.0, -2.0, 1.0)
    poses = solve([start, start], [motion(0, 1, SE2(1.0, 0.0, 0.0))], KERNEL)
    assert poses[0].between(start).distance < TOL_M
    assert poses[1].between(start @ SE2(1.0, 0.0, 0.0)).distance < TOL_M


def test_a_loop_takes_most_of_the_drift():
    truth = square()
    edges = drifting(chain(truth), 0.05)
    before = along(edges)
    loop = motion(0, 8, SE2.identity().between(truth[8]), is_loop=True, cov=SURE)
    after = solve(before, [*edges, loop], KERNEL)
    assert largest_error(after, truth) < 0.25 * largest_error(before, truth)


def test_a_false_loop_pulls_far_less_than_without_a_kernel():
    truth = square()
    false = motion(2, 6, truth[2].between(truth[6]) @ SE2(3.0, 0.0, 0.0), is_loop=True, cov=SURE)
    true = [motion(k, 8 - k, truth[k].between(truth[8 - k]), True, SURE) for k in (0, 1, 3)]
    robust = solve(truth, [*chain(truth), *true, false], KERNEL)
    plain = solve(truth, [*chain(truth), *true, false], 1e6)
    assert largest_error(robust, truth) < 0.1 * largest_error(plain, truth)


def test_deviations_are_those_of_the_edge():
    edge = motion(0, 1, SE2(1.0, 0.0, 0.0), cov=LOOSE)
    assert deviations(edge, [SE2.identity(), SE2(1.1, 0.0, 0.0)]) == pytest.approx(2.0)
    assert deviations(edge, [SE2.identity(), SE2(1.0, 0.0, 0.04)]) == pytest.approx(2.0)


def test_deviations_of_many_edges_are_those_of_each():
    rng = np.random.default_rng(0)
    poses = [SE2(*rng.normal(0.0, 2.0, 3)) for _ in range(12)]
    edges = [motion(k, (5 * k + 1) % 12, SE2(*rng.normal(0.0, 2.0, 3))) for k in range(12)]
    for edge, found in zip(edges, deviations_of(edges, poses), strict=True):
        off = edge.T_first_second.between(poses[edge.first].between(poses[edge.second])).as_array()
        assert found == pytest.approx(np.sqrt(off @ np.linalg.inv(LOOSE) @ off))
    assert deviations_of([], poses).shape == (0,)


def test_a_solver_that_has_solved_before_solves_as_a_new_one():
    truth = square()
    edges = drifting(chain(truth), 0.05)
    loop = motion(0, 8, truth[0].between(truth[8]), is_loop=True, cov=SURE)
    false = motion(2, 6, SE2(3.0, 0.0, 0.0), is_loop=True, cov=SURE)
    solver = GraphSolver()
    solver.solve(along(edges), [*edges, loop, false], KERNEL)
    again = solver.solve(along(edges), [*edges, loop], KERNEL)
    assert again == solve(along(edges), [*edges, loop], KERNEL)


def test_a_quick_solution_is_near_the_final_one():
    truth = square()
    edges = drifting(chain(truth), 0.05)
    loop = motion(0, 8, truth[0].between(truth[8]), is_loop=True, cov=SURE)
    graph = along(edges), [*edges, loop], KERNEL
    assert largest_error(GraphSolver().solve(*graph, QUICK_TOLERANCE), solve(*graph)) < 0.01


def test_the_whole_graph_may_lie_anywhere():
    truth = square()
    edges = drifting(chain(truth), 0.05)
    loop = motion(0, 8, truth[0].between(truth[8]), is_loop=True, cov=SURE)
    T = SE2(5.0, -3.0, 2.0)
    here = solve(along(edges), [*edges, loop], KERNEL)
    there = solve([T @ pose for pose in along(edges)], [*edges, loop], KERNEL)
    assert largest_error([T @ pose for pose in here], there) < 1e-3


def test_a_missing_solver_is_one_clear_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "gtsam", None)
    with pytest.raises(ValueError, match="needs the package gtsam.*loop_closing to false"):
        load_solver()
