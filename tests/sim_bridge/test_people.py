"""Walkers: plans by hand, forces, noticing and yielding, laws of the whole."""

import math
from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.forces import kept_apart, push_between, push_of_walls
from sim_bridge.people.obstacles import Obstacles
from sim_bridge.people.people import People, drawn_walkers
from sim_bridge.people.schema import Crowd, WalkerPlan
from sim_bridge.people.walkers import Walkers
from sim_bridge.people.yielding import Robot, Traits, attention_after, draw_traits, side_step
from sim_bridge.solids import Solid

CONFIG = PeopleConfig()
EMPTY = Obstacles([])
DT, STEP_NS = 0.01, 10_000_000
PERSON = Traits(speed=1.2, notice_distance=4.0, notice_time=0.6, side=-1)


def _box(x: float, y: float, size: tuple[float, float, float], yaw: float = 0.0) -> Solid:
    return Solid("box", SE2(x, y, yaw), size, 0.0, False, (0.5, 0.5, 0.5))


def _people(*plans: WalkerPlan, config: PeopleConfig = CONFIG, T: SE2 | None = None) -> People:
    return People(config, plans, None, None, [], SE2.identity() if T is None else T)


def _walk(people: People, seconds: float, robots: list[Robot] | None = None) -> list:
    seen = []
    for k in range(round(seconds / DT)):
        people.step(k * STEP_NS, DT, robots or [])
        seen.append(people.truth())
    return seen


def _standing_robot(x: float, y: float) -> Robot:
    return Robot(np.array([x, y]), np.zeros(2), 0.4)


def test_a_scripted_walker_is_where_its_plan_says() -> None:
    plan = WalkerPlan(
        name="a", path_m=((0, 0), (2, 0), (2, 1)), speed_m_s=1.0, pauses_s=(0, 0.5), starts_s=1.0
    )
    seen = _walk(_people(plan), 6.0)
    at = {t: seen[round(t / DT) - 1][0].pose for t in (1.0, 2.0, 3.0, 3.4, 4.0, 5.5)}
    expected = {1.0: (0, 0), 2.0: (1, 0), 3.0: (2, 0), 3.4: (2, 0), 4.0: (2, 0.5), 5.5: (2, 1)}
    for time, place in expected.items():
        assert (at[time].x, at[time].y) == pytest.approx(place, abs=0.011), time


def test_to_and_fro_goes_on_for_ever() -> None:
    plan = WalkerPlan(name="a", path_m=((0, 0), (1, 0)), speed_m_s=1.0, repeats=True)
    xs = np.array([people[0].pose.x for people in _walk(_people(plan), 8.0)])
    assert xs.max() == pytest.approx(1.0, abs=0.011) and xs.min() == pytest.approx(0.0, abs=0.011)
    assert (np.diff(np.sign(np.diff(xs))) != 0).sum() >= 6


def test_a_walker_sets_out_when_a_robot_is_near() -> None:
    plan = WalkerPlan(name="a", path_m=((0, 0), (0, 3)), speed_m_s=1.0, starts_within_m=2.0)
    people, skin = _people(plan), CONFIG.torso_radius_m
    far, near = _standing_robot(skin + 2.1, 0.0), _standing_robot(skin + 1.9, 0.0)
    assert _walk(people, 1.0, [far])[-1][0].pose.y == 0.0
    assert _walk(people, 1.0, [near])[-1][0].pose.y == pytest.approx(1.0)


def test_that_distance_is_from_the_robots_laser() -> None:
    plan = WalkerPlan(name="a", path_m=((0, 0), (0, 3)), speed_m_s=1.0, starts_within_m=2.0)
    middle = np.array([2.5, 0.0])
    walked = [
        _walk(_people(plan), 1.0, [Robot(middle, np.zeros(2), 0.4, eye)])[-1][0].pose.y
        for eye in (None, middle - [0.2, 0.0], middle - [0.4, 0.0])
    ]
    assert walked == pytest.approx([0.0, 0.0, 1.0])


def test_who_is_said_to_notice_still_draws_how_far_off() -> None:
    config = PeopleConfig(notice_distance_m=4.0, notice_distance_sd_m=1.0)
    plans = [
        WalkerPlan(name=f"p{k}", path_m=((k, 0),), is_reacting=True, never_notices=False)
        for k in range(400)
    ]
    drawn = [t.notice_distance for t in Walkers(config, plans, EMPTY, 0).traits]
    assert np.mean(drawn) == pytest.approx(4.0, abs=0.15)
    assert np.std(drawn) == pytest.approx(1.0, abs=0.15)
    assert min(drawn) >= 1.0
    never = [replace(plan, never_notices=True) for plan in plans[:20]]
    assert {t.notice_distance for t in Walkers(config, never, EMPTY, 0).traits} == {0.0}


def test_nearness_speeds_up_noticing() -> None:
    times = []
    for distance in (4.0, 2.0, 1.0):
        attention, time = 0.0, 0.0
        while attention < 1.0:
            attention = attention_after(CONFIG, PERSON, attention, 0.0, distance, DT)
            time += DT
        times.append(time)
    assert times == pytest.approx([0.6, 0.3, 0.15], abs=0.011)


def test_what_is_behind_or_too_far_is_not_noticed() -> None:
    assert attention_after(CONFIG, PERSON, 0.5, math.pi, 1.0, DT) == 0.0
    assert attention_after(CONFIG, PERSON, 0.5, 0.0, 4.1, DT) == 0.0


def test_people_differ_as_much_as_the_model_says() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_traits(CONFIG, rng) for _ in range(4000)]
    never = np.mean([traits.notice_distance == 0.0 for traits in drawn])
    distances = np.array([t.notice_distance for t in drawn if t.notice_distance > 0.0])
    assert never == pytest.approx(CONFIG.never_share, abs=0.02)
    assert distances.mean() == pytest.approx(CONFIG.notice_distance_m, abs=0.06)
    assert distances.std() == pytest.approx(CONFIG.notice_distance_sd_m, abs=0.06)
    assert np.median([t.notice_time for t in drawn]) == pytest.approx(0.6, abs=0.03)
    assert np.mean([t.side == -1 for t in drawn]) == pytest.approx(CONFIG.right_share, abs=0.03)


def test_head_on_the_step_aside_is_square_to_the_motion_and_to_the_drawn_side() -> None:
    robot = Robot(np.array([3.0, 0.0]), np.array([-0.5, 0.0]), 0.4)
    aside = side_step(CONFIG, PERSON, np.zeros(2), np.array([1.2, 0.0]), robot, 0)
    # 3 m at 1.7 m/s leave 1.76 s, half of which is for 0.4 + 0.2 + 0.45 = 1.05 m: over 0.7 m/s.
    assert aside.side == -1 and aside.direction == pytest.approx([0.0, -1.0])
    assert aside.speed == pytest.approx(0.7)


def test_who_passes_clear_does_not_step_aside() -> None:
    robot = Robot(np.array([3.0, 1.2]), np.zeros(2), 0.4)
    aside = side_step(CONFIG, PERSON, np.zeros(2), np.array([1.2, 0.0]), robot, 0)
    assert aside.side == 0 and aside.speed == 0.0


def test_who_is_off_the_middle_steps_to_the_nearer_side() -> None:
    robot = Robot(np.array([3.0, -0.4]), np.zeros(2), 0.4)
    aside = side_step(CONFIG, PERSON, np.zeros(2), np.array([1.2, 0.0]), robot, 0)
    assert aside.side == 1 and aside.speed * aside.direction[1] > 0.0


@pytest.mark.parametrize("never", [True, False])
def test_a_reacting_walker_goes_round_a_robot_unless_it_never_notices(never: bool) -> None:
    plan = WalkerPlan(
        name="a", path_m=((0, 0), (8, 0)), speed_m_s=1.2, is_reacting=True, never_notices=never
    )
    seen = _walk(_people(plan), 8.0, [_standing_robot(4.0, 0.0)])
    nearest = min(math.hypot(p[0].pose.x - 4.0, p[0].pose.y) for p in seen)
    assert seen[-1][0].has_noticed != never
    assert nearest < 0.05 if never else nearest > 0.4 + CONFIG.torso_radius_m + 0.2
    assert seen[-1][0].pose.x > 7.0


def test_a_standing_person_makes_room_and_comes_back() -> None:
    plan = WalkerPlan(name="a", path_m=((0, 0),), is_reacting=True, never_notices=False)
    people, nearest, farthest = _people(plan), math.inf, 0.0
    for k in range(1600):
        robot = Robot(np.array([4.0 - 0.6 * k * DT, 0.0]), np.array([-0.6, 0.0]), 0.4)
        people.step(k * STEP_NS, DT, [robot])
        pose = people.truth()[0].pose
        nearest = min(nearest, math.hypot(pose.x - robot.position[0], pose.y))
        farthest = max(farthest, math.hypot(pose.x, pose.y))
    assert nearest > 0.4 + CONFIG.torso_radius_m + 0.2
    assert farthest > 0.8 and math.hypot(pose.x, pose.y) < 0.15


def test_a_wall_hides_a_robot() -> None:
    wall = _box(2.0, 0.0, (0.1, 4.0, 2.4))
    obstacles = Obstacles([wall])
    assert obstacles.is_hidden(np.zeros(2), np.array([4.0, 0.0]))
    assert not obstacles.is_hidden(np.zeros(2), np.array([4.0, 4.5]))
    assert not Obstacles([_box(2.0, 0.0, (0.1, 4.0, 0.8))]).is_hidden(
        np.zeros(2), np.array([4.0, 0.0])
    )


def test_distance_and_way_off_a_turned_box() -> None:
    obstacles = Obstacles([_box(1.0, 1.0, (2.0, 1.0, 2.0), yaw=math.pi / 2.0)])
    distance, away = obstacles.away(np.array([[3.0, 1.0], [1.0, 4.0]]))
    assert distance[:, 0] == pytest.approx([1.5, 2.0])
    assert np.allclose(away[:, 0], [[1.0, 0.0], [0.0, 1.0]])


def test_the_push_of_people_is_the_slope_of_their_potential() -> None:
    rng = np.random.default_rng(0)
    p, q, v = rng.normal(0.0, 1.0, (3, 1, 2))

    def potential(place: np.ndarray) -> float:
        r, step = (place - q)[0], (CONFIG.people_ahead_s * v)[0]
        reach = np.hypot(*r) + np.hypot(*(r - step))
        b = 0.5 * math.sqrt(reach**2 - step @ step)
        return CONFIG.people_push_m2_s2 * math.exp(-b / CONFIG.people_range_m)

    h = 1e-6
    slope = [(potential(p + d) - potential(p - d)) / (2 * h) for d in h * np.eye(2)[:, None, :]]
    assert np.allclose(push_between(CONFIG, p, q, v)[0, 0], -np.array(slope), rtol=1e-5)


def test_the_push_of_a_wall_by_hand() -> None:
    obstacles = Obstacles([_box(0.0, -0.5, (10.0, 1.0, 2.0))])
    push = push_of_walls(CONFIG, np.array([[0.0, 0.4]]), obstacles)
    assert push[0] == pytest.approx([0.0, 10.0 / 0.2 * math.exp(-2.0)])


def test_bodies_that_overlap_part_by_half_each() -> None:
    here = np.array([[0.0, 0.0], [0.3, 0.0], [5.0, 0.0]])
    assert np.allclose(kept_apart(here, here, 0.4), [[-0.05, 0.0], [0.35, 0.0], [5.0, 0.0]])


def test_moving_the_world_moves_people_with_it() -> None:
    plan = WalkerPlan(name="a", path_m=((0, 0), (6, 0)), is_reacting=True, never_notices=False)
    T = SE2(-3.0, 5.0, 2.1)
    here = _walk(_people(plan), 5.0, [_standing_robot(3.0, 0.1)])[-1][0]
    place = T @ np.array([[3.0, 0.1]])
    there = _walk(_people(plan, T=T), 5.0, [Robot(place[0], np.zeros(2), 0.4)])[-1][0]
    off = (T @ here.pose).between(there.pose)
    assert off.distance < 1e-9 and abs(off.yaw) < 1e-9
    assert math.hypot(*there.velocity) == pytest.approx(math.hypot(*here.velocity))


def test_a_crowd_keeps_apart_and_off_walls() -> None:
    hall = [_box(0, y, (10, 0.2, 2.4)) for y in (-3.1, 3.1)]
    hall += [_box(x, 0, (0.2, 6, 2.4)) for x in (-5, 5)] + [_box(0, 0, (0.5, 0.5, 2.4))]
    crowd = Crowd(num=12, low_m=(-4.4, -2.4), high_m=(4.4, 2.4))
    people = People(CONFIG, (), crowd, None, hall, SE2.identity())
    obstacles, gaps, walked = Obstacles(hall), [], np.zeros(12)
    last = None
    for k in range(2000):
        people.step(k * STEP_NS, DT, [])
        places = np.array([[p.pose.x, p.pose.y] for p in people.truth()])
        pairs = np.linalg.norm(places[:, None] - places[None], axis=2) + 9.0 * np.eye(12)
        gaps.append(pairs.min())
        assert obstacles.away(places)[0].min() > 0.05
        walked += 0.0 if last is None else np.hypot(*(places - last).T)
        last = places
    assert min(gaps) > 0.25 and np.median(gaps) > 2.0 * CONFIG.torso_radius_m - 0.02
    assert walked.min() > 8.0


def test_the_same_seed_draws_the_same_crowd_and_one_more_changes_nobody() -> None:
    small, large = (Crowd(num=n, low_m=(0, 0), high_m=(8, 5)) for n in (5, 6))
    first = drawn_walkers(small, EMPTY, 3)
    assert drawn_walkers(small, EMPTY, 3) == first
    assert drawn_walkers(large, EMPTY, 3)[:5] == first
    assert drawn_walkers(small, EMPTY, 4) != first


def test_reset_brings_people_back() -> None:
    crowd = Crowd(num=6, low_m=(0, 0), high_m=(8, 5))
    people = People(CONFIG, (), crowd, None, [], SE2.identity())
    people.reset(5)
    first = _walk(people, 3.0)
    people.reset(5)
    assert _walk(people, 3.0) == first
