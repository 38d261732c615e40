"""Poses corrected by the nodes round them."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from grid_mapper.corrections import NO_NODE, Corrections

LOCAL = [SE2(0.0, 0.0, 0.0), SE2(2.0, 0.0, 0.0)]
SOLVED = [SE2(1.0, 0.0, 0.0), SE2(3.4, 0.0, 0.0)]


def test_a_pose_between_two_nodes_is_corrected_as_both_by_nearness():
    corrections = Corrections.of(LOCAL, SOLVED)
    assert corrections.at(0, SE2(0.5, 0.0, 0.0)).x == pytest.approx(1.5 + 0.25 * 0.4)
    assert corrections.at(0, LOCAL[0]) == SOLVED[0]
    assert corrections.at(1, LOCAL[1]).x == pytest.approx(3.4)


def test_after_the_last_node_the_front_end_leads_on():
    corrections = Corrections.of(LOCAL, [SOLVED[0], SE2(3.0, 1.0, np.pi / 2.0)])
    for node in (1, 2, 7):
        pose = corrections.at(node, SE2(3.0, 0.0, 0.1))
        assert pose.as_array() == pytest.approx([3.0, 2.0, np.pi / 2.0 + 0.1])
    assert corrections.T_map_local.between(SE2(3.0, -1.0, np.pi / 2.0)).distance < 1e-12


def test_without_nodes_nothing_is_corrected():
    pose = SE2(1.0, 2.0, 3.0)
    assert Corrections.of([], []).at(NO_NODE, pose) == pose
    assert Corrections.of([], []).T_map_local == SE2.identity()
    assert Corrections.of(LOCAL, SOLVED).at(NO_NODE, pose) == pose


def test_a_turn_across_half_a_circle_takes_the_shorter_way():
    local = [SE2(0.0, 0.0, 3.1), SE2(1.0, 0.0, -3.1)]
    pose = Corrections.of(local, local).at(0, SE2(0.5, 0.0, 3.14))
    assert pose.as_array() == pytest.approx([0.5, 0.0, 3.14], abs=1e-9)
