import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from loop_builders import closed, drifted, frames_at, largest_error, ring, round_the_ring

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.frame_thinning import CELL_M, TURN_RAD, thinned_frames
from grid_mapper.loop_config import LoopConfig

ROOM = ring()
ONE = frames_at([SE2(0.0, -4.0, 0.0)], [SE2(0.0, -4.0, 0.0)], ROOM)[0]


def has_scan(frames):
    return [len(frame.points) > 0 for frame in frames]


def test_the_newest_of_a_place_stay():
    here, there = SE2(0.1, 0.1, 0.1), SE2(2.1, 0.1, 0.1)
    poses = [here, here, there, here, SE2(0.1, 0.1, 0.1 + TURN_RAD)]
    assert has_scan(thinned_frames([ONE] * 5, poses, 2)) == [False, True, True, True, True]


def test_what_goes_leaves_no_scan_and_what_stays_is_the_same():
    kept = thinned_frames([ONE] * 3, [SE2(0.1, 0.1, 0.1)] * 3, 2)
    assert len(kept[0].scan.ranges) == 0 and kept[0].T_local_base == ONE.T_local_base
    assert kept[1] is ONE and kept[2] is ONE


@given(st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)), max_size=60))
def test_no_place_keeps_more_and_thinning_again_changes_nothing(rows):
    poses = [SE2(*row) for row in rows]
    kept = thinned_frames([ONE] * len(poses), poses, 2)
    places = [(p.x // CELL_M, p.y // CELL_M, p.yaw // TURN_RAD)
              for p, stays in zip(poses, has_scan(kept), strict=True) if stays]  # fmt: skip
    assert all(places.count(place) <= 2 for place in places)
    assert set(places) == {(p.x // CELL_M, p.y // CELL_M, p.yaw // TURN_RAD) for p in poses}
    assert has_scan(thinned_frames(kept, poses, 2)) == has_scan(kept)


def test_laps_without_end_keep_a_bounded_number_of_scans_and_still_close_their_loops():
    truth = round_the_ring(480, 4.0)
    frames = frames_at(truth, drifted(truth, 0.0005), ROOM, np.random.default_rng(0))
    closer = closed(frames, GridMapperConfig(loop=LoopConfig(max_scans_a_place=2)))
    late = [len(frame.points) > 0 for frame in closer.frames]
    assert sum(late) < 330 and all(late[-80:])
    ends = {end for edge in closer.edges for end in (edge.first, edge.second)}
    assert len(ends) == closer.num_free < 360  # the graph is of what is not merged
    assert largest_error(closer.poses, truth) < 0.1
    assert any(edge.is_loop and edge.second > 400 for edge in closer.edges)
