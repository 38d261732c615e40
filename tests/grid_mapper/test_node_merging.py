import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loop_builders import SURE, frames_at, largest_error, motion, ring

from floornav_common.se2 import SE2
from grid_mapper.frame_thinning import emptied
from grid_mapper.node_merging import Merge, MergedNodes, contracted, merges_of, moved_edge

HERE = SE2(0.1, 0.1, 0.1)
FRAME = frames_at([HERE], [HERE], ring())[0]
poses = st.builds(SE2, st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3))


def merge(node, into, T=None, var_m2=0.0, var_rad2=0.0):
    return Merge(node, into, T or SE2(0.1, 0.2, 0.3), var_m2, var_rad2)


def error(edge, at):
    return edge.T_first_second.between(at[edge.first].between(at[edge.second])).distance


@given(st.lists(poses, min_size=4, max_size=4))
def test_an_edge_that_fits_the_poses_fits_them_after_its_ends_were_merged(at):
    edge = motion(0, 1, at[0].between(at[1]))
    by_node = {0: merge(0, 2, at[2].between(at[0])), 1: merge(1, 3, at[3].between(at[1]))}
    moved = moved_edge(edge, by_node)
    assert (moved.first, moved.second) == (2, 3) and error(moved, at) < 1e-9
    assert moved_edge(edge, {5: merge(5, 2)}) is edge


def test_a_moved_edge_is_less_sure_by_what_is_not_known_of_the_merge():
    edge = motion(0, 1, SE2(3.0, 0.0, 0.0), cov=np.diag([0.01, 0.02, 0.003]))
    first = moved_edge(edge, {0: merge(0, 2, SE2(0.1, 0.0, 0.0), 0.04, 0.01)})
    assert np.allclose(first.cov, np.diag([0.01, 0.02, 0.003]) + np.diag([0.13, 0.13, 0.01]))
    second = moved_edge(edge, {1: merge(1, 2, SE2(0.5, 0.0, 0.0), 0.04, 0.01)})
    lever = (0.003 + 0.01) * 0.25
    expected = np.diag([0.01, 0.02, 0.003]) + np.diag([0.04 + lever, 0.04 + lever, 0.01])
    assert np.allclose(second.cov, expected)


def test_a_turned_node_turns_what_its_edge_is_sure_of():
    edge = motion(0, 1, SE2(1.0, 0.0, 0.0), cov=np.diag([0.01, 0.09, 1e-6]))
    moved = moved_edge(edge, {1: merge(1, 2, SE2(0.0, 0.0, np.pi / 2.0))})
    assert np.allclose(moved.cov, np.diag([0.09, 0.01, 1e-6]))


def test_of_edges_between_the_same_nodes_the_chain_stays_and_else_the_surest():
    T = SE2(0.3, 0.0, 0.0)
    chain = [motion(k, k + 1, T) for k in range(3)]
    loose, sure = (motion(3, 0, T, is_loop=True, cov=c * SURE) for c in (4.0, 1.0))
    other = motion(0, 2, T, is_loop=True)
    left = contracted([*chain, loose, sure, other], [merge(1, 0, SE2.identity())])
    # 0-1 is within a node; 1-2 is now 0-2, where it takes the place of the loop.
    assert [(e.first, e.second, e.is_loop) for e in left] == [
        (0, 2, False), (2, 3, False), (3, 0, True), (3, 0, True),
    ]  # fmt: skip
    left = contracted([loose, sure, *chain], [merge(3, 2, SE2.identity())])
    assert [e for e in left if e.is_loop][0].cov[0, 0] == pytest.approx(SURE[0, 0])
    assert sum(e.is_loop for e in left) == 1


def test_merged_nodes_go_where_the_others_go():
    at = [SE2(1.0, 0.0, 0.0), SE2(2.0, 1.0, 0.5), SE2(0.0, 3.0, -2.0)]
    merged = MergedNodes()
    merged.add([merge(0, 1, at[1].between(at[0]))])
    merged.add([merge(1, 2, at[2].between(at[1]))])
    T = SE2(4.0, -2.0, 1.0)
    placed = merged.placed([SE2.identity(), SE2.identity(), T @ at[2]])
    assert largest_error(placed, [T @ pose for pose in at]) < 1e-9
    assert merged.is_free(4).tolist() == [False, False, True, True] and len(merged) == 2


def test_only_what_lost_its_scan_is_merged_and_only_where_the_graph_is_sure():
    frames, at = [emptied(FRAME), FRAME, FRAME, emptied(FRAME)], [HERE] * 4
    sure = [motion(k, k + 1, SE2.identity(), cov=SURE) for k in range(3)]
    all_free = np.ones(4, bool)
    found = {m.node: m for m in merges_of(frames, at, sure, all_free)}
    assert set(found) == {0, 3} and {m.into for m in found.values()} <= {1, 2}
    assert found[0].var_m2 == pytest.approx(SURE[0, 0] * (1 if found[0].into == 1 else 2))
    vague = [motion(k, k + 1, SE2.identity(), cov=np.eye(3)) for k in range(3)]
    assert merges_of(frames, at, vague, all_free) == []
    elsewhere = [SE2(5.0, 0.0, 0.0), HERE, HERE, SE2(9.0, 0.0, 0.0)]
    assert merges_of(frames, elsewhere, sure, all_free) == []
