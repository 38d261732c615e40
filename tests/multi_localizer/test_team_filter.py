"""The team's filter: known answers, derivatives, laws, starts, losses, and its consistency."""

from __future__ import annotations

import numpy as np
import pytest
from team_worlds import LANDMARKS, STARTS, STEP_NS, World

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference, normalized_error
from multi_localizer.team_filter import TeamFilter
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_filter_kernels import NOT_A_ROBOT, SIZE, look, predict_robot
from multi_localizer.team_sightings import Sighting

TOL = 1e-9
NS = 1_000_000_000
CERTAIN = dict.fromkeys(
    ("offset_sd_rad", "travel_scale_sd", "turn_scale_sd", "curve_sd", "drag_sd"), 0.0
)
CONFIG = TeamFilterConfig(repeat_s=0.0, bearing_sd_rad=0.01)


def certain(pose: SE2, sd: float = 0.1) -> PoseEstimate:
    return PoseEstimate(pose, np.diag([sd**2, sd**2, sd**2]))


def placed(config: TeamFilterConfig = CONFIG, sd: float = 0.1) -> TeamFilter:
    team = TeamFilter(list(STARTS), LANDMARKS, config)
    for name, pose in STARTS.items():
        team.place(name, certain(pose, sd))
    return team


def test_a_meter_ahead_moves_the_pose_and_widens_it_as_configured() -> None:
    config = TeamFilterConfig(
        travel_noise=0.1, sideways_noise=0.02, turn_noise_way=0.03, scale_walk=0.0, **CERTAIN
    )
    team = TeamFilter(["r"], {}, config)
    team.place("r", PoseEstimate(SE2(1.0, 2.0, np.pi / 2), np.diag([0.04, 0.01, 1e-8])))
    team.predict("r", SE2(1.0, 0.0, 0.0), NS)
    there = team.estimates()["r"]
    assert there.pose.as_array() == pytest.approx([1.0, 3.0, np.pi / 2], abs=TOL)
    expected = [0.04 + 0.02**2 + 1e-8, 0.01 + 0.1**2, 1e-8 + 0.03**2]
    assert np.diag(there.cov) == pytest.approx(expected, rel=1e-6)


def test_a_given_covariance_takes_the_place_of_the_configured_noise() -> None:
    team = TeamFilter(["r"], {}, TeamFilterConfig(scale_walk=0.0, **CERTAIN))
    team.place("r", PoseEstimate(SE2(0.0, 0.0, np.pi / 2), np.diag([1e-6, 1e-6, 1e-9])))
    team.predict("r", SE2(1e-9, 0.0, 0.0), NS, np.diag([0.09, 0.0, 0.0]))
    assert team.estimates()["r"].cov[1, 1] == pytest.approx(0.09, rel=1e-3)


def test_one_bearing_tells_across_and_nothing_along() -> None:
    team = TeamFilter(["r"], {"a": np.array([2.0, 0.0])}, TeamFilterConfig(**CERTAIN))
    team.place("r", PoseEstimate(SE2.identity(), np.diag([0.25, 0.25, 1e-6])))
    team.update("r", [Sighting(0.0, ("a",))], NS)
    cov = team.estimates()["r"].cov
    assert cov[0, 0] == pytest.approx(0.25, abs=1e-6)
    assert cov[1, 1] < 0.001


def random_state(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    mean = rng.normal(0.0, 1.0, 2 * SIZE)
    mean[SIZE] += 5.0
    mean[3::SIZE] *= 0.02
    for state in (4, 5, 6, 7, 8):
        mean[state::SIZE] *= 0.05
    root = rng.normal(0.0, 0.1, (2 * SIZE, 2 * SIZE))
    return mean, root @ root.T


@pytest.mark.parametrize("seed", range(5))
def test_the_covariance_moves_by_the_motion_s_derivative(seed: int) -> None:
    mean, cov = random_state(seed)
    motion = np.array([0.3, 0.1, -0.4])
    none, walk = np.zeros((3, 3)), np.zeros(SIZE)

    def moved(state: np.ndarray) -> np.ndarray:
        state = state.copy()
        predict_robot(state, np.zeros_like(cov), 1, motion, none, walk, 0.7)
        return state

    F = derivative(moved, mean)
    after = cov.copy()
    predict_robot(mean.copy(), after, 1, motion, none, walk, 0.7)
    assert after == pytest.approx(F @ cov @ F.T, abs=1e-6)


@pytest.mark.parametrize("target", [NOT_A_ROBOT, 1])
@pytest.mark.parametrize("seed", range(3))
def test_the_gain_is_the_bearing_s_derivative(seed: int, target: int) -> None:
    mean, cov = random_state(seed)
    point = np.array([2.0, -1.5])
    gain = np.zeros(mean.size)

    def expected(state: np.ndarray) -> np.ndarray:
        return np.array([-look(state, cov, 0, 0.0, target, point, np.zeros(state.size))[0]])

    H = derivative(expected, mean)
    _, var = look(mean, cov, 0, 0.0, target, point, gain)
    assert gain == pytest.approx((cov @ H.T)[:, 0], abs=1e-6)
    assert var == pytest.approx(float((H @ cov @ H.T)[0, 0]), abs=1e-6)


def derivative(function, at: np.ndarray) -> np.ndarray:
    columns = []
    for k in range(at.size):
        step = np.zeros(at.size)
        step[k] = 1e-6
        columns.append((function(at + step) - function(at - step)) / 2e-6)
    return np.array(columns).T


def test_turning_the_map_turns_the_answer() -> None:
    T_new_old = SE2(3.0, -2.0, 2.1)
    answers = []
    for T in (SE2.identity(), T_new_old):
        landmarks = {k: (T @ p.reshape(1, 2))[0] for k, p in LANDMARKS.items()}
        team = TeamFilter(list(STARTS), landmarks, CONFIG)
        for name, pose in STARTS.items():
            guess = SE2(pose.x + 0.05, pose.y - 0.03, pose.yaw + 0.02)
            team.place(name, certain(T @ guess))
        world = World(np.random.default_rng(3), bearing_sd=0.01, travel_noise=0.05)
        for _ in range(20):
            world.step(team)
            for name in STARTS:
                world.look(team, name)
        answers.append({k: e.pose for k, e in team.estimates().items()})
    for name in STARTS:
        there = (T_new_old @ answers[0][name]).as_array()
        assert answers[1][name].as_array() == pytest.approx(there, abs=1e-6)


def test_scales_and_offset_are_learned_on_the_way() -> None:
    config = TeamFilterConfig(repeat_s=0.0, bearing_sd_rad=0.005)
    team = placed(config)
    world = World(
        np.random.default_rng(1), bearing_sd=0.005, travel_scale=0.95, turn_scale=0.9, offset=0.02
    )
    for _ in range(150):
        world.step(team)
        for name in STARTS:
            world.look(team, name)
    for name in STARTS:
        errors = team.errors_of(name)
        told_turn = 0.06 * errors.turn + 0.08 * errors.curve
        told_way = errors.travel + errors.drag * 0.06 / (STEP_NS / NS)
        assert told_way == pytest.approx(-0.05, abs=0.02)
        assert told_turn == pytest.approx(-0.1 * 0.06, abs=0.002)
        assert errors.offset == pytest.approx(0.02, abs=0.01)


def test_a_robot_that_slows_down_in_curves_is_learned_to() -> None:
    """Told 0.4 m/s always, it drives that straight on and half of it at 0.5 rad/s."""
    config = TeamFilterConfig(repeat_s=0.0, bearing_sd_rad=0.005, drag_sd=1.0)
    team = placed(config)
    world = World(np.random.default_rng(9), bearing_sd=0.005)
    for step in range(200):
        is_curve = step // 10 % 2
        world.travel_scale = 0.5 if is_curve else 1.0
        world.step(team, turn=0.1 if is_curve else 0.0)
        for name in STARTS:
            world.look(team, name)
    for name in STARTS:
        assert team.errors_of(name).drag == pytest.approx(-1.0, abs=0.15)
        assert team.errors_of(name).travel == pytest.approx(0.0, abs=0.05)


def test_a_robot_that_sees_no_landmark_is_held_by_its_teammates() -> None:
    far = {}
    for has_team in (False, True):
        team = placed()
        world = World(np.random.default_rng(2), bearing_sd=0.01, turn_noise=0.1, sees=("r1", "r2"))
        for _ in range(100):
            world.step(team)
            for name in STARTS:
                if has_team or name != "r3":
                    seen = world.sightings(name)
                    team.update(
                        name, [s for s in seen if has_team or s.meanings[0] in LANDMARKS],
                        world.stamp_ns,
                    )  # fmt: skip
        off = difference(team.estimates()["r3"].pose, world.poses["r3"])
        far[has_team] = float(np.hypot(off[0], off[1]))
    assert far[True] < 0.08
    assert far[True] < 0.5 * far[False]


def test_a_wild_bearing_is_left_out_and_changes_nothing() -> None:
    team = placed()
    before = {k: e.pose for k, e in team.estimates().items()}
    looks = team.update("r1", [Sighting(2.0, ("a",))], NS)
    assert not looks.is_used[0]
    assert looks.deviations[0] > CONFIG.gate_sd**2
    assert {k: e.pose for k, e in team.estimates().items()} == before


def test_names_told_by_geometry_are_those_left_out() -> None:
    team = placed(sd=0.03)
    world = World(np.random.default_rng(4), bearing_sd=0.01)
    for _ in range(20):
        world.step(team)
        for name in STARTS:
            looks = world.look(team, name, is_named=False)
            assert looks.meanings[len(LANDMARKS) :] == tuple(k for k in STARTS if k != name)


def test_a_bearing_that_fits_two_robots_alike_is_left_open() -> None:
    team = TeamFilter(["r1", "r2", "r3"], {}, CONFIG)
    for name, pose in {"r1": SE2.identity(), "r2": SE2(3, 0.1, 0), "r3": SE2(3, -0.1, 0)}.items():
        team.place(name, certain(pose))
    looks = team.update("r1", [Sighting(0.0, ("r2", "r3"))], NS)
    assert looks.meanings == ("",)
    assert not looks.is_used[0]


def test_robots_find_their_start_from_bearings_alone() -> None:
    team = TeamFilter(list(STARTS), LANDMARKS, CONFIG)
    world = World(np.random.default_rng(5), bearing_sd=0.01)
    for _ in range(10):
        world.step(team)
        for name in STARTS:
            world.look(team, name)
    found = team.estimates()
    assert set(found) == set(STARTS)
    for name, estimate in found.items():
        off = difference(estimate.pose, world.poses[name])
        assert np.hypot(off[0], off[1]) < 0.1
        assert abs(off[2]) < 0.03


def test_a_robot_is_started_by_those_who_see_it() -> None:
    team = TeamFilter(list(STARTS), LANDMARKS, CONFIG)
    world = World(np.random.default_rng(6), bearing_sd=0.01, sees=("r1", "r2"))
    for _ in range(20):
        world.step(team)
        for name in STARTS:
            world.look(team, name)
    off = difference(team.estimates()["r3"].pose, world.poses["r3"])
    assert np.hypot(off[0], off[1]) < 0.15


def test_standing_before_two_landmarks_is_no_start() -> None:
    team = TeamFilter(["r1"], {k: LANDMARKS[k] for k in ("a", "b")}, CONFIG)
    world = World(np.random.default_rng(7), poses={"r1": STARTS["r1"]}, bearing_sd=0.001)
    seen = [s for s in world.sightings("r1") if s.meanings[0] in ("a", "b")]
    for k in range(20):
        team.update("r1", seen, k * NS // 2)
    assert not team.estimates()


def test_a_robot_that_was_carried_away_is_lost_and_found() -> None:
    team = placed()
    world = World(np.random.default_rng(8), bearing_sd=0.01)
    world.poses["r1"] = SE2(-2.0, -2.5, 0.0)
    far = []
    for _ in range(60):
        world.step(team, turn=0.02)
        for name in STARTS:
            world.look(team, name)
        offs = {k: difference(e.pose, world.poses[k]) for k, e in team.estimates().items()}
        far.append({k: float(np.hypot(off[0], off[1])) for k, off in offs.items()})
    assert far[0]["r1"] > 1.0
    assert all(step["r1"] < 0.1 for step in far[10:])
    assert all(step[name] < 0.2 for step in far for name in ("r2", "r3"))


def test_covariances_are_true_over_many_drives() -> None:
    """The mean of 40 x 3 values of NEES lies in the 95 % band of chi-squared over 360 degrees.

    Robots of a team share errors, so their values are not independent: the band is 1.5 times that.
    """
    config = TeamFilterConfig(
        repeat_s=0.0, bearing_sd_rad=0.02, travel_noise=0.1, sideways_noise=0.0,
        turn_noise_way=0.0, turn_noise=0.1, scale_walk=0.0, offset_walk=0.0, soft_sd=10.0,
        gate_sd=10.0, **CERTAIN,
    )  # fmt: skip
    values = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        team = TeamFilter(list(STARTS), LANDMARKS, config)
        for name, pose in STARTS.items():
            off = rng.normal(0.0, 0.05, 3)
            guess = SE2(pose.x + off[0], pose.y + off[1], pose.yaw + off[2])
            team.place(name, certain(guess, 0.05))
        world = World(rng, travel_noise=0.1, turn_noise=0.1, bearing_sd=0.02)
        for _ in range(40):
            world.step(team)
            for name in STARTS:
                world.look(team, name)
        values += [
            normalized_error(e.pose, world.poses[k], e.cov) for k, e in team.estimates().items()
        ]
    spread = 1.96 * np.sqrt(2.0 * 360) / 120
    assert abs(np.mean(values) - 3.0) < 1.5 * spread


def test_robots_placed_together_move_together() -> None:
    """Of two robots whose errors are alike to 0.9, half of what one moves by is 0.45 for both."""
    team = TeamFilter(["r1", "r2"], {}, CONFIG)
    cov = np.kron([[1.0, 0.9], [0.9, 1.0]], np.eye(3))
    team.place_jointly(["r1", "r2"], [], np.array([0.0, 0.0, 0.0, 2.0, 0.0, 0.0]), cov)
    assert team.update_pose("r1", certain(SE2(1.0, 0.0, 0.0), 1.0), NS)
    found = team.estimates()
    assert found["r1"].pose.as_array() == pytest.approx([0.5, 0.0, 0.0])
    assert found["r2"].pose.as_array() == pytest.approx([2.45, 0.0, 0.0])
    assert found["r2"].cov[0, 0] == pytest.approx(1.0 - 0.9**2 / 2.0)


def test_a_robot_is_placed_as_seen_from_one_that_is_known_better() -> None:
    """The answer has both 1 m off; that the second is 2 m ahead of the first it knows to 0.1 m."""
    team = TeamFilter(["r1", "r2"], {}, CONFIG)
    team.place("r1", certain(SE2(1.0, 0.0, 0.0), 0.1))
    cov = np.kron([[1.01, 1.0], [1.0, 1.0]], np.eye(3))
    team.place_jointly(["r2"], ["r1"], np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0]), cov)
    found = team.estimates()
    assert found["r1"].pose.x == pytest.approx(1.0)
    assert found["r2"].pose.x == pytest.approx(3.0)
    assert np.diag(found["r2"].cov) == pytest.approx([0.02] * 3)
    team.update_pose("r1", certain(SE2(1.1, 0.0, 0.0), 0.1), NS)
    assert team.estimates()["r2"].pose.x == pytest.approx(3.05)


def test_own_poses_that_follow_each_other_soon_count_for_less() -> None:
    team = TeamFilter(["r"], {}, TeamFilterConfig(repeat_s=6.0))
    team.place("r", certain(SE2.identity()))
    for k in range(2):
        team.update_pose("r", certain(SE2.identity()), k * NS)
    assert team.estimates()["r"].cov[0, 0] == pytest.approx(1.0 / (200.0 + 100.0 / 7.0))


def test_an_own_pose_out_of_the_question_changes_nothing() -> None:
    team = placed()
    before = {k: e.pose for k, e in team.estimates().items()}
    assert not team.update_pose("r1", certain(SE2(9.0, 9.0, 0.0)), NS)
    assert {k: e.pose for k, e in team.estimates().items()} == before


def test_a_robot_that_is_forgotten_may_begin_at_any_stamp_and_from_nothing_seen_before() -> None:
    team = TeamFilter(["r1"], LANDMARKS, CONFIG)
    world = World(np.random.default_rng(5), poses={"r1": STARTS["r1"]}, bearing_sd=0.01)
    team.predict("r1", SE2.identity(), 9 * NS)
    seen = world.sightings("r1")
    team.update("r1", seen[:3], 9 * NS)
    team.forget("r1")
    team.predict("r1", SE2.identity(), NS)
    team.update("r1", seen[3:], NS)
    assert not team.estimates()


def test_repeated_bearings_count_for_less_than_new_ones() -> None:
    sds = []
    for gap_ns in (NS // 10, 100 * NS):
        config = TeamFilterConfig(repeat_s=6.0, offset_walk=0.0, **CERTAIN)
        team = TeamFilter(["r"], {"a": np.array([2.0, 0.0])}, config)
        team.place("r", certain(SE2.identity()))
        for k in range(10):
            team.update("r", [Sighting(0.0, ("a",))], k * gap_ns)
        cov = team.estimates()["r"].cov
        sds.append(np.sqrt(cov[1, 1] / 4.0 + cov[2, 2] + cov[1, 2]))
    assert sds[0] > 1.5 * sds[1]


def test_bad_input_is_refused_by_name() -> None:
    team = placed()
    with pytest.raises(ValueError, match="'nobody'"):
        team.predict("nobody", SE2.identity(), 0)
    with pytest.raises(ValueError, match="'moon'"):
        team.update("r1", [Sighting(0.0, ("moon",))], 0)
    with pytest.raises(ValueError, match=r"\['a'\] twice"):
        TeamFilter(["r1", "a"], LANDMARKS, CONFIG)
    with pytest.raises(ValueError, match=r"\['r1'\] twice"):
        TeamFilter(["r1", "r1"], {}, CONFIG)
    with pytest.raises(ValueError, match="at least one robot"):
        TeamFilter([], {}, CONFIG)
    team.predict("r1", SE2.identity(), STEP_NS)
    with pytest.raises(ValueError, match="must not go back"):
        team.predict("r1", SE2.identity(), 0)


def test_a_bearing_that_is_not_a_number_is_passed_over() -> None:
    team = placed()
    before = team.estimates()["r1"].cov
    looks = team.update("r1", [Sighting(np.nan, ("a",)), Sighting(np.nan, ("r2", "r3"))], NS)
    assert not looks.is_used.any()
    assert np.array_equal(team.estimates()["r1"].cov, before)


def test_a_robot_that_sees_itself_learns_nothing() -> None:
    team = placed()
    looks = team.update("r1", [Sighting(0.3, ("r1",))], NS)
    assert looks.meanings == ("",)
