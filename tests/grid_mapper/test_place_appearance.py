import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import scan_at, square_room

from floornav_common.se2 import SE2
from grid_mapper.place_appearance import BIN_M, NUM_BINS, Appearances, signature


def ring(radius, num=50):
    angles = np.linspace(0.0, 2.0 * np.pi, num, endpoint=False)
    return radius * np.column_stack((np.cos(angles), np.sin(angles)))


def differences(*clouds, num_round=0):
    looks = Appearances(num_round)
    for cloud in clouds:
        looks.add(cloud)
    return looks.differences()


def test_a_signature_is_the_share_of_points_within_each_bin():
    points = np.array([[0.2, 0.0], [0.0, 0.7], [0.0, -0.8], [99.0, 0.0]])
    found = signature(points)
    assert found[:3].tolist() == [0.25, 0.75, 0.75]
    assert found[NUM_BINS - 2] == 0.75 and found[NUM_BINS - 1] == 1.0


def test_walls_two_meters_farther_differ_by_two_meters():
    assert differences(ring(1.2), ring(3.2)) == pytest.approx([2.0, 0.0])


def test_half_of_the_points_one_bin_farther_differ_by_half_a_bin():
    mixed = np.vstack((ring(1.2), ring(1.2 + BIN_M)))
    assert differences(mixed, ring(1.2))[0] == pytest.approx(0.5 * BIN_M)


@given(turn=st.floats(-3.0, 3.0))
def test_a_turn_changes_no_signature(turn):
    points = scan_at(SE2(0.3, -0.4, 0.2), square_room()).points()
    turned = SE2(0.0, 0.0, turn) @ points
    off_a_border = np.abs(np.hypot(*points.T) / BIN_M % 1.0 - 0.5) < 0.499
    assert np.array_equal(signature(points[off_a_border]), signature(turned[off_a_border]))


def test_a_place_is_the_mean_of_the_nodes_round_it():
    found = differences(ring(1.2), ring(2.2), ring(1.2), ring(1.2), num_round=1)
    # Of node 1 a third of the points is 1 m farther, of the newest none; node 0 has half.
    assert found == pytest.approx([0.5, 1.0 / 3.0, 1.0 / 3.0, 0.0])


def test_no_points_are_no_error():
    assert differences(np.zeros((0, 2)), ring(1.2))[1] == 0.0
