from dataclasses import replace

import numpy as np
import pytest
from loop_builders import (
    NS,
    closed,
    drifted,
    frames_at,
    largest_error,
    motion,
    ring,
    round_the_ring,
)
from worlds import box, moved_walls, scan_at, square_room

from floornav_common.se2 import SE2
from grid_mapper import loop_closer
from grid_mapper.config import GridMapperConfig
from grid_mapper.key_frames import KeyFrame, chain_edge
from grid_mapper.loop_candidates import Candidate
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_config import LoopConfig
from grid_mapper.loop_verification import Verdict, agree, are_apart, seen_through, verify

CONFIG = GridMapperConfig()
SMALL = LoopConfig(submap_nodes=2)
NUM, LAPS = 110, 1.25


@pytest.fixture(scope="module")
def lap():
    """A lap and a quarter round the ring, with a front end that turns a little too far."""
    truth = round_the_ring(NUM, LAPS)
    local = drifted(truth, turn_per_step=0.001, stretch=1.004)
    return truth, frames_at(truth, local, ring(), np.random.default_rng(0))


def test_coming_round_closes_the_loop(lap):
    truth, frames = lap
    before = largest_error([frame.T_local_base for frame in frames], truth)
    closer = closed(frames)
    assert before > 0.5
    assert closer.num_loops > 10
    assert largest_error(closer.poses, truth) < 0.3 * before


def test_every_loop_is_a_true_one(lap):
    truth, frames = lap
    for edge in closed(frames).edges:
        if edge.is_loop:
            off = edge.T_first_second.between(truth[edge.first].between(truth[edge.second]))
            assert off.distance < 0.1 and abs(off.yaw) < 0.03


def test_the_same_frames_give_the_same_poses_to_the_bit(lap):
    _, frames = lap
    first, second = closed(frames), closed(frames)
    assert [p.as_array().tolist() for p in first.poses] == [
        p.as_array().tolist() for p in second.poses
    ]


def test_a_far_loop_waits_for_a_second_that_agrees(lap, monkeypatch):
    """Where the graph is not sure of itself one match closes nothing, two that agree both."""
    _, frames = lap
    closer = LoopCloser(replace(CONFIG, loop=LoopConfig(search_distance_m=1e3)))
    for frame in frames:
        closer.add(frame)

    def matched(first, second, off=0.0, sigma=1.0):
        T = closer.poses[first].between(closer.poses[second]) @ SE2(off, 0.0, 0.0)
        edge = motion(first, second, T, is_loop=True)
        monkeypatch.setattr(loop_closer, "verify", lambda *_: Verdict(edge, ""))
        return edge, closer._compare(Candidate(second, first, sigma, 0.1))

    one, found = matched(10, 95)
    assert found == [] and closer._pending == [one]
    assert matched(11, 95)[1] == []  # of the same scans
    assert matched(30, 105, off=1.0)[1] == []  # of others, but it says something else
    other, found = matched(32, 106)
    assert one in found and other in found and one not in closer._pending
    near, found = matched(50, 60, sigma=1e-3)  # where it is sure one will do
    assert found == [near]


def test_two_loops_of_the_same_scans_are_one_witness():
    here, T = motion(20, 50, SE2.identity(), is_loop=True), SE2.identity()
    assert not are_apart(here, motion(20, 80, T), 6)  # the same place looks the same again
    assert not are_apart(here, motion(50, 52, T), 6)
    assert not are_apart(here, motion(32, 57, T), 6)
    assert are_apart(here, motion(33, 57, T), 6) and are_apart(motion(33, 57, T), here, 6)


def test_a_place_that_looks_like_another_is_not_believed_for_looking_so_twice():
    """A corridor that ends as it begins: two scans of its end lie on its beginning, both wrong."""
    corner = np.vstack([box(-1.0, -1.2, 3.0, 1.2), box(0.9, 0.6, 1.5, 1.2)])
    walls = np.vstack([corner, moved_walls(SE2(5.0, 0.0, 0.0), corner)])
    begin = [SE2(0.3 * k, 0.0, 0.0) for k in range(7)]
    turns = np.linspace(0.0, 6.2, 40)
    around = [SE2(2.0 + 10.0 * np.sin(a), 10.0 - 10.0 * np.cos(a), a) for a in turns]
    end = [SE2(5.0 + 0.3 * k, 0.0, 0.0) for k in range(5)]
    seen = [*begin, *around, *end]
    frames = frames_at(seen, seen, walls)
    closer = LoopCloser(replace(CONFIG, loop=LoopConfig(drift_m=0.2, search_distance_m=0.0)))
    for frame in frames:
        closer.add(frame)
    assert closer.num_loops == 0


def test_what_slides_along_a_wall_is_no_loop_where_the_graph_is_not_sure():
    corridor = np.array([[-20.0, -1.0, 20.0, -1.0], [-20.0, 1.0, 20.0, 1.0]])
    path = [SE2(0.3 * k, 0.0, 0.0) for k in range(5)]
    frames = frames_at(path + path, path + path, corridor)
    far, near = (
        verify(frames, path + path, Candidate(9, 2, sigma, 0.02), SMALL, CONFIG.matcher)
        for sigma in (0.4, 0.0)
    )
    assert far.edge is None and far.reason == "slides"
    assert near.edge is not None, near.reason
    assert near.edge.cov[0, 0] > 5.0**2 and near.edge.cov[1, 1] < 0.05**2


def test_a_false_loop_is_taken_out_again(lap):
    truth, frames = lap
    closer = LoopCloser(CONFIG)
    for frame in frames:
        closer.add(frame)
    last = len(frames) - 1
    wrong = truth[30].between(truth[last]) @ SE2(1.5, 0.5, 0.2)
    closer.edges.append(motion(30, last, wrong, is_loop=True, cov=1e-4 * np.eye(3)))
    closer.solve()
    assert closer.refused["does not fit the graph"] == 1
    assert largest_error(closer.poses, truth) < 0.3


def test_another_room_of_the_same_shape_but_other_furniture_is_refused():
    here = SE2(-1.5, -1.8, 0.0)
    path = [here @ SE2(0.3 * k, 0.0, 0.0) for k in range(5)]
    bare = square_room()[:4]  # the same outer walls
    full = np.vstack([bare, *(box(x, 0.0, x + 0.8, 0.8) for x in (-3.5, -1.5, 0.5, 2.5))])
    frames = frames_at(path, path, full) + frames_at(path, path, bare)
    poses = path + path
    verdict = verify(frames, poses, Candidate(9, 2, 0.3, 0.1), SMALL, CONFIG.matcher)
    assert verdict.edge is None and verdict.reason == "seen through"


def test_the_same_place_is_found_from_far_off_and_its_motion_is_right():
    path = [SE2(-1.5 + 0.3 * k, -1.8, 0.1 * k) for k in range(5)]
    again = [pose @ SE2(0.05, 0.1, 0.2) for pose in path]
    frames = frames_at(path + again, path + again, square_room())
    off = SE2(0.6, -0.4, 0.15)
    poses = path + [off @ pose for pose in again]
    verdict = verify(frames, poses, Candidate(9, 2, 0.4, 0.1), SMALL, CONFIG.matcher)
    assert verdict.edge is not None, verdict.reason
    error = verdict.edge.T_first_second.between(path[2].between(again[4]))
    assert error.distance < 0.03 and abs(error.yaw) < 0.01


def test_a_scan_sees_through_a_wall_that_is_not_there():
    T = SE2(0.0, 0.0, 0.3)
    frame = frames_at([T], [T], square_room())[0]
    assert seen_through(frame, frame.points) == 0.0
    nearer = replace(frame.points, points=0.5 * frame.points.points)
    assert seen_through(frame, nearer) > 0.9


def test_loops_agree_when_they_lead_to_one_place():
    poses = [SE2(float(k), 0.0, 0.0) for k in range(4)] + [SE2(5.0 + k, 9.0, 0.0) for k in range(4)]
    T = SE2(0.2, -0.1, 0.05)
    first, second = motion(1, 5, T), motion(2, 6, SE2(-1, 0, 0) @ T @ SE2(1, 0, 0))
    assert agree(first, second, poses, CONFIG.loop)
    assert not agree(first, motion(2, 6, T @ SE2(0.0, 2.0, 0.0)), poses, CONFIG.loop)


def test_moving_the_world_moves_the_result_with_it(lap):
    truth, frames = lap
    T = SE2(7.0, -3.0, 2.0)
    moved = [replace(frame, T_local_base=T @ frame.T_local_base, information=turned(frame, T))
             for frame in frames]  # fmt: skip
    here, there = closed(frames).poses, closed(moved).poses
    assert largest_error([T @ pose for pose in here], there) < 0.05


def turned(frame, T):
    c, s = np.cos(T.yaw), np.sin(T.yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return R @ frame.information @ R.T


def test_the_chain_is_surer_where_the_match_says_more():
    scan = scan_at(SE2.identity(), moved_walls(SE2.identity(), square_room()))
    front = frames_at([SE2.identity()], [SE2.identity()], square_room())[0]
    after = KeyFrame(NS, SE2(0.5, 0.0, 0.0), np.diag([1e-3, 1e4, 1e4]), front.points, scan,
                     SE2.identity())  # fmt: skip
    edge = chain_edge(1, front, after, CONFIG.motion, (1e-3, 1e-3))
    assert edge.T_first_second.x == pytest.approx(0.5)
    assert edge.cov[0, 0] == pytest.approx((0.005 + 0.1 * 0.5) ** 2, rel=0.01)
    assert edge.cov[1, 1] < 0.02**2


def found_again(off: SE2):
    """Return what a closer makes of a robot carried back to an earlier place and found `off` it."""
    truth = round_the_ring(NUM, LAPS)
    way = truth[:60] + truth[5:25]
    T_said = truth[5] @ off @ truth[5].inverse()
    believed = truth[:60] + [T_said @ pose for pose in truth[5:25]]
    closer = LoopCloser(CONFIG)
    frames = frames_at(way, believed, ring(), np.random.default_rng(4))
    for k, frame in enumerate(frames):
        closer.add(frame, follows_jump=k == 60)
    closer.solve()
    return way, closer


def test_a_robot_found_again_is_tied_to_what_it_was_found_by_and_not_to_what_it_was_carried_from():
    way, closer = found_again(SE2(0.05, -0.03, 0.01))
    (over,) = [e for e in closer.edges if not e.is_loop and e.T_first_second.distance > 2.0]
    (tie,) = [e for e in closer.edges if e.second == 60 and e.is_loop and e.first == 5][:1]
    assert np.sqrt(over.cov[0, 0]) > 10.0
    off = tie.T_first_second.between(way[tie.first].between(way[60])).as_array()
    assert np.sqrt(off @ np.linalg.solve(tie.cov, off)) < 3.0
    assert largest_error(closer.poses, way) < 0.06


def test_a_robot_wrongly_found_again_is_put_right_by_the_loops_that_follow():
    way, closer = found_again(SE2(0.5, 0.3, 0.08))
    assert closer.refused["does not fit the graph"] >= 1
    assert largest_error(closer.poses, way) < 0.1
