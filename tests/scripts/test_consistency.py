import numpy as np
import pytest
from loop_builders import frames_at, ring

from experiments import consistency
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.key_frames import Edge
from grid_mapper.loop_closer import LoopCloser

LOOP = GridMapperConfig().loop
COV = np.diag([0.02, 0.03, 0.01]) ** 2


def test_nees_by_hand():
    errors, covs = (
        np.array([[0.2, 0.0, 0.1], [0.0, 0.0, 0.0]]),
        np.array(2 * [np.diag([0.04, 1, 0.01])]),
    )
    assert consistency.nees(errors, covs) == pytest.approx([2.0, 0.0])


def test_errors_drawn_from_their_covariance_lie_in_the_band_and_twice_as_large_ones_do_not():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    cov = root @ root.T + 0.1 * np.eye(3)
    errors = rng.multivariate_normal(np.zeros(3), cov, 2000)
    covs = np.broadcast_to(cov, (2000, 3, 3))
    figures = consistency.figures(consistency.nees(errors, covs), 2000)
    assert figures["low"] < figures["mean"] < figures["high"]
    assert figures["median"] == pytest.approx(2.37, abs=0.15)
    assert figures["beyond_share"] == pytest.approx(0.05, abs=0.015)
    large = consistency.figures(consistency.nees(2.0 * errors, covs), 2000)
    assert large["mean"] == pytest.approx(4.0 * figures["mean"]) and large["mean"] > large["high"]


def test_the_band_is_that_of_the_chi_square_table():
    low, high = consistency.band(10)  # chi-square of 30: 16.79 and 46.98
    assert (low, high) == (pytest.approx(1.679, abs=1e-3), pytest.approx(4.698, abs=1e-3))


def random_graph(num, rng):
    """Return a graph of a square drive whose edges err as they say, solved, and the truth."""
    closer = LoopCloser(GridMapperConfig())
    truth = [SE2(0.0, 0.0, 0.0)]
    for k in range(num - 1):
        truth.append(truth[-1] @ SE2(1.0, 0.0, np.pi / 2.0 if k % 5 == 4 else 0.0))
    pairs = [(k, k + 1) for k in range(num - 1)] + [(k, k + 20) for k in range(0, num - 20, 7)]
    for a, b in pairs:
        off = SE2(*rng.multivariate_normal(np.zeros(3), COV))
        seen = truth[a].between(truth[b]) @ off
        closer.edges.append(Edge(a, b, seen, COV, is_loop=b - a > 1))
    closer.frames = frames_at(truth[:1], truth[:1], ring()) * num
    closer.poses = list(truth)
    closer.solve()
    return closer, truth


def test_a_graph_whose_edges_say_the_truth_is_consistent_and_one_too_sure_is_not():
    rng = np.random.default_rng(1)
    drives = []
    for _ in range(12):
        closer, truth = random_graph(41, rng)
        shifted = [SE2(3.0, -2.0, 1.0) @ pose for pose in truth]
        poses, covs = closer.poses, [np.eye(3)] * len(truth)
        drives.append(consistency.drive_nees(closer, shifted, poses, covs, truth))
    found = consistency.drive_figures(drives, LOOP)
    for kind in ("chain", "loops", "after"):
        assert found[kind]["low"] < found[kind]["mean"] < found[kind]["high"], kind
    assert found["before"]["mean"] < 0.1  # covariances of a meter
    assert [found[kind]["num"] for kind in ("chain", "loops", "before", "after")] == [
        480,
        36,
        480,
        48,
    ]


def test_drives_are_pooled_by_how_many_errors_they_have():
    few, many = np.full(10, 1.0), np.full(30, 9.0)
    drives = [{k: consistency.figures(v, 1) for k in consistency.KINDS} for v in (few, many)]
    found = consistency.pooled(drives, LOOP)["chain"]
    assert (found["num"], found["mean"], found["beyond_share"]) == (40, 7.0, 0.75)
    none = {kind: consistency.figures(np.zeros(0), 0) for kind in consistency.KINDS}
    assert consistency.pooled([none], LOOP)["loops"]["mean"] is None
    assert "-" in str(consistency.table({"a": none}).rows)
