"""People followed from scan to scan."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scans import Circle, Wall, drawn_scan

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.obstacle_state import Tracks
from sjmc_planner.people_tracker import PeopleTracker
from sjmc_planner.planning import Obstacles
from sjmc_planner.tracking_config import TrackingConfig

ROOM: list[Wall] = [(-5, -5, 5, -5), (5, -5, 5, 5), (5, 5, -5, 5), (-5, 5, -5, -5)]
STILL = SE2.identity()
TOL_M_S = 0.15
DT = 0.1


def follow(
    circles_at, poses=None, walls=ROOM, num=25, seed=0, tracker=None, T_base_sensor=STILL, **scan
) -> list[Tracks]:  # type: ignore[no-untyped-def]
    """Return the tracks of each scan of circles at a time, seen from poses at a time."""
    rng = np.random.default_rng(seed)
    tracker = PeopleTracker(TrackingConfig()) if tracker is None else tracker
    found, last = [], None
    for k in range(num):
        pose = STILL if poses is None else poses(DT * k)
        seen = drawn_scan(
            circles_at(DT * k), walls, pose @ T_base_sensor, noise=0.01, rng=rng, **scan
        )
        moved = STILL if last is None else last.between(pose)
        found.append(tracker.update(Obstacles(seen, T_base_sensor), moved, DT))
        last = pose
    return found


def one_near(tracks: Tracks, x: float, y: float) -> int:
    off = np.hypot(*(tracks.position - (x, y)).T)
    assert off.min() < 0.2, f"nobody at {x}, {y}: {tracks.position}"
    return int(np.argmin(off))


def test_nobody_in_an_empty_room() -> None:
    assert len(follow(lambda t: [])[-1]) == 0


def test_a_walker_is_followed_with_its_velocity() -> None:
    last = follow(lambda t: [(3.0 - 1.2 * t, 0.5, 0.2)], num=20)[-1]
    n = one_near(last, 3.0 - 1.2 * 1.9, 0.5)
    assert np.allclose(last.velocity[n], (-1.2, 0.0), atol=TOL_M_S)
    assert last.is_moving[n] > 0.9
    assert last.unseen_s[n] == 0.0


def test_who_walks_has_a_velocity_within_half_a_second() -> None:
    tracks = follow(lambda t: [(2.0, -2.0 + 1.0 * t, 0.2)], num=6)[-1]
    assert tracks.velocity[0, 1] > 0.7


def test_who_walks_ahead_of_the_robot_as_fast_as_it_is_seen_to_move() -> None:
    last = follow(
        lambda t: [(1.6 + 0.5 * t, 0.0, 0.2)], lambda t: SE2(0.5 * t, 0.0, 0.0), walls=[], num=20
    )[-1]
    assert last.is_moving[0] > 0.7
    assert np.allclose(last.velocity[0], (0.5, 0.0), atol=TOL_M_S)


def test_who_stands_has_none() -> None:
    for tracks in follow(lambda t: [(2.0, 0.5, 0.2), (-1.0, 1.0, 0.25)])[3:]:
        assert len(tracks) == 2
        assert np.hypot(*tracks.velocity.T).max() < 0.05
        assert tracks.is_moving.max() < 0.3


def test_legs_of_a_walker_are_one_person() -> None:
    def legs(t: float) -> list[Circle]:
        x, swing = -2.0 + 1.2 * t, 0.35 * np.sin(2.0 * np.pi * 0.85 * t)
        return [(x + swing, 1.61, 0.065), (x - swing, 1.39, 0.065)]

    velocities = []
    for k, tracks in enumerate(follow(legs, num=30)):
        if k < 15:
            continue
        n = one_near(tracks, -2.0 + 1.2 * DT * k, 1.5)
        velocities.append(tracks.velocity[n])
        assert (np.hypot(*(tracks.position - tracks.position[n]).T) < 0.8).sum() == 1
    assert np.allclose(velocities, (1.2, 0.0), atol=0.7)  # one leg hides the other now and then
    assert np.allclose(np.mean(velocities, axis=0), (1.2, 0.0), atol=0.2)


def test_a_robot_that_drives_and_turns_gives_things_no_velocity() -> None:
    def pose(t: float) -> SE2:
        return SE2(-2.0 + 0.6 * t, 0.3 * np.sin(t), 0.8 * np.sin(0.9 * t))

    things: list[Circle] = [(1.0, 1.2, 0.15), (0.5, -1.0, 0.05), (0.8, -1.0, 0.05), (2.5, 0.0, 0.3)]
    walls = [*ROOM, (1.5, 1.5, 1.5, 2.0), (0.0, -2.0, 0.6, -2.4)]
    mount = SE2(0.2, 0.0, 0.0)
    for tracks in follow(lambda t: things, pose, walls, 40, T_base_sensor=mount, fov=4.2)[3:]:
        assert np.hypot(*tracks.velocity.T).max(initial=0.0) < 0.2


def test_velocities_are_over_the_ground_in_the_axes_of_the_base() -> None:
    def pose(t: float) -> SE2:
        return SE2(-3.0 + 0.5 * t, 0.0, 0.4 * t)

    last_t = 2.4
    last = follow(lambda t: [(1.0, -2.0 + 1.0 * t, 0.2)], pose)[-1]
    (at,) = pose(last_t).inverse() @ np.array([[1.0, -2.0 + last_t]])
    n = one_near(last, *at)
    yaw = pose(last_t).yaw
    assert np.allclose(last.velocity[n], (np.sin(yaw), np.cos(yaw)), atol=TOL_M_S)


def test_two_who_cross_keep_their_numbers() -> None:
    def two(t: float) -> list[Circle]:
        return [(2.0, -1.5 + 1.2 * t, 0.2), (2.7, 1.5 - 1.2 * t, 0.2)]

    found = follow(two, num=28)
    early, late = found[8], found[-1]
    for x, sign in ((2.0, 1.0), (2.7, -1.0)):
        before = early.number[one_near(early, x, sign * (-1.5 + 1.2 * 0.8))]
        after = late.number[one_near(late, x, sign * (-1.5 + 1.2 * 2.7))]
        assert before == after


def test_who_is_hidden_is_carried_on_and_taken_up_again() -> None:
    def behind(t: float) -> list[Circle]:
        return [(3.0, -1.5 + 1.2 * t, 0.2), (1.5, 0.05, 0.2)]

    found = follow(behind, num=28)
    before = found[8].number[one_near(found[8], 3.0, -1.5 + 1.2 * 0.8)]
    assert max(t.unseen_s.max(initial=0.0) for t in found) >= 0.1
    assert found[-1].number[one_near(found[-1], 3.0, -1.5 + 1.2 * 2.7)] == before


def test_who_is_gone_is_forgotten_at_once_where_it_is_seen_that_nobody_is_there() -> None:
    def leaves(t: float) -> list[Circle]:
        return [(2.0, 0.0, 0.2)] if t < 1.0 else []

    found = follow(leaves, num=16)
    assert len(found[9]) == 1
    assert len(found[-1]) == 0


def test_a_scan_given_twice_adds_only_time() -> None:
    tracker = PeopleTracker(TrackingConfig())
    follow(lambda t: [(3.0 - 1.0 * t, 0.5, 0.2)], tracker=tracker, num=15)
    scan = drawn_scan([(3.0 - 1.4, 0.5, 0.2)], ROOM)
    seen = tracker.update(Obstacles(scan, STILL), STILL, 0.0)
    again = tracker.update(Obstacles(scan, STILL), STILL, 0.05)
    assert np.allclose(again.position, seen.position + 0.05 * seen.velocity, atol=0.01)
    assert np.allclose(again.unseen_s, 0.05)


def test_beams_name_whom_they_met() -> None:
    last = follow(lambda t: [(2.0, 0.0, 0.2), (0.0, 2.0, 0.2)])[-1]
    scan = drawn_scan([(2.0, 0.0, 0.2), (0.0, 2.0, 0.2)], ROOM)
    for n, place in enumerate(last.position):
        ends = (scan.ranges[:, None] * np.column_stack((np.cos(scan.angles), np.sin(scan.angles))))[
            last.beam_track == n
        ]
        assert len(ends) > 10
        assert np.hypot(*(ends - place).T).max() < 0.3
    assert (last.beam_track == -1).sum() > 500


def test_a_mirrored_scene_gives_mirrored_tracks() -> None:
    tracks = []
    for sign in (1.0, -1.0):
        tracker = PeopleTracker(TrackingConfig())
        rng = np.random.default_rng(3)
        for k in range(15):
            circles: list[Circle] = [
                (3.0 - 0.1 * k, 0.5, 0.2), (1.0, -1.0 + 0.08 * k, 0.065), (1.3, -1.1, 0.065)
            ]  # fmt: skip
            scan = drawn_scan(circles, ROOM, noise=0.01, rng=rng, num_beams=721, fov=4.2)
            ranges = scan.ranges if sign > 0.0 else scan.ranges[::-1].copy()
            scan = Scan(ranges, scan.angle_min, scan.angle_increment, 0.05, 8.0)
            moved = SE2(0.0, 0.0, 0.0)
            last = tracker.update(Obstacles(scan, STILL), moved, DT)
        order = np.argsort(last.position[:, 0])
        tracks.append((last.position[order] * (1.0, sign), last.velocity[order] * (1.0, sign)))
    assert np.allclose(tracks[0][0], tracks[1][0], atol=1e-9)
    assert np.allclose(tracks[0][1], tracks[1][1], atol=1e-9)


def test_a_sensor_that_hangs_head_down_sees_the_same() -> None:
    tracker = PeopleTracker(TrackingConfig())
    for k in range(15):
        scan = drawn_scan([(3.0 - 0.1 * k, 0.5, 0.2)], ROOM)
        scan = Scan(
            scan.ranges[::-1].copy(), scan.angles[-1], -scan.angle_increment, 0.05, scan.range_max
        )
        last = tracker.update(Obstacles(scan, STILL), STILL, DT)
    assert np.allclose(last.velocity[one_near(last, 1.6, 0.5)], (-1.0, 0.0), atol=TOL_M_S)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 0.0])
def test_a_scan_that_says_nothing_is_taken(value: float) -> None:
    tracker = PeopleTracker(TrackingConfig())
    follow(lambda t: [(2.0, 0.0, 0.2)], tracker=tracker, num=5)
    scan = drawn_scan()
    scan.ranges[:] = value
    assert len(tracker.update(Obstacles(scan, STILL), STILL, DT)) <= 1


def test_a_clock_that_jumps_forgets_everybody() -> None:
    tracker = PeopleTracker(TrackingConfig())
    assert len(follow(lambda t: [(2.0, 0.0, 0.2)], tracker=tracker)[-1]) == 1
    scan = drawn_scan([(2.0, 0.0, 0.2)], ROOM)
    assert len(tracker.update(Obstacles(scan, STILL), STILL, -1.0)) == 0


def test_another_kind_of_scan_may_come() -> None:
    tracker = PeopleTracker(TrackingConfig())
    follow(lambda t: [(2.0, 0.0, 0.2)], tracker=tracker)
    last = follow(lambda t: [(2.0, 0.0, 0.2)], tracker=tracker, num_beams=361)[-1]
    assert len(last) == 1


def test_twenty_people_are_all_followed_and_errors_fit_their_covariance() -> None:
    rng = np.random.default_rng(5)
    start = np.column_stack(
        (np.repeat(np.linspace(-3.5, 3.5, 5), 4), np.tile([-3.5, -2, 2, 3.5], 5))
    )
    v = rng.uniform(-0.5, 0.5, (20, 2))
    last = follow(lambda t: [(*p, 0.2) for p in start + v * t], num=15, num_beams=1081)[-1]
    errors = []
    for p, velocity in zip(start + v * 1.4, v, strict=True):
        off = np.hypot(*(last.position - p).T)
        if off.min() < 0.2:
            n = int(np.argmin(off))
            e = np.concatenate((last.position[n] - p, last.velocity[n] - velocity))
            errors.append(e @ np.linalg.solve(last.cov[n], e))
    assert len(errors) >= 16  # some stand behind others
    assert np.median(errors) < 9.5  # chi^2 of four dimensions, 95 %
