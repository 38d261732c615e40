"""From sightings to a pose: right, consistent, or refused with a reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import Sighting, estimate_of, fit_pose, is_curved, residuals
from multi_localizer.landmark_locator import LandmarkLocator, sightings_of
from multi_localizer.landmarks import Landmark, Landmarks, load_landmarks
from multi_localizer.pose_estimate import difference, normalized_error

CONFIG = LandmarkConfig()
UNCONFIRMED = LandmarkConfig(min_spare=0)
SD = CONFIG.bearing_sd_rad
FIELD = load_landmarks("middle_size_field")
ENDS = FIELD
POLES: Landmarks = {
    "pole": tuple(Landmark((p,)) for p in ((4.0, 0.3), (-4.0, 1.0), (0.5, 3.0), (1.5, -2.5)))
}


def seen_from(
    pose: SE2, landmarks: Landmarks, rng: np.random.Generator | None = None, sd: float = SD
) -> dict[str, np.ndarray]:
    place = np.array([pose.x, pose.y])
    found = {}
    for kind, marks in landmarks.items():
        rays = np.array([mark.point_seen(place) for mark in marks]) - place
        b = np.arctan2(rays[:, 1], rays[:, 0]) - pose.yaw
        found[kind] = b if rng is None else b + rng.normal(0.0, sd, len(b))
    return found


def located(
    bearings: dict[str, np.ndarray], landmarks: Landmarks = FIELD, config: LandmarkConfig = CONFIG
):
    return LandmarkLocator(landmarks, config).locate(sightings_of(bearings, config))


def ring_of(num: int) -> Landmarks:
    """Return unlike poles on an ellipse round the origin."""
    angles = 2.0 * math.pi * np.arange(num) / num
    return {
        f"m{k}": (Landmark(((4.5 * math.cos(a), 3.0 * math.sin(a)),)),)
        for k, a in enumerate(angles)
    }


def random_pose(rng: np.random.Generator) -> SE2:
    return SE2(rng.uniform(-3.0, 3.0), rng.uniform(-1.8, 1.8), rng.uniform(-3.1, 3.1))


def test_the_ends_of_both_goals_give_the_pose() -> None:
    pose = SE2(1.0, -0.7, 0.6)
    fix = located(seen_from(pose, ENDS), ENDS)
    assert fix.problem == "" and fix.num_used == 4
    assert difference(fix.estimate.pose, pose) == pytest.approx(np.zeros(3), abs=1e-6)


def test_poles_that_look_alike_are_told_apart() -> None:
    pose = SE2(-1.2, 0.4, -2.0)
    fix = located({"pole": seen_from(pose, POLES)["pole"][[2, 0, 3, 1]]}, POLES)
    assert fix.problem == ""
    assert difference(fix.estimate.pose, pose) == pytest.approx(np.zeros(3), abs=1e-6)


def test_the_jacobian_is_that_of_finite_differences() -> None:
    pose = SE2(0.4, -0.2, 0.3)
    marks = [m for kind in POLES.values() for m in kind]
    seen = [Sighting("pole", 0.3 * k, 0.02, 2.0 + k, 0.1) for k in range(len(marks))]
    r, J = residuals(pose, seen, marks)
    for k, (dx, dy, dyaw) in enumerate(1e-6 * np.eye(3)):
        moved, _ = residuals(SE2(pose.x + dx, pose.y + dy, pose.yaw + dyaw), seen, marks)
        assert (moved - r) / 1e-6 == pytest.approx(J[:, k], rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("landmarks", [ENDS, POLES], ids=["ends", "poles"])
def test_covariances_are_true(landmarks: Landmarks) -> None:
    rng = np.random.default_rng(1)
    off, num_none = [], 0
    for _ in range(150):
        pose = random_pose(rng)
        fix = located(seen_from(pose, landmarks, rng), landmarks)
        if fix.estimate is None:
            num_none += 1
        else:
            off.append(normalized_error(fix.estimate.pose, pose, fix.estimate.cov))
    assert num_none < 25
    assert np.mean(off) == pytest.approx(3.0, abs=4.0 * math.sqrt(6.0 / len(off)))


def test_a_false_bearing_is_left_out() -> None:
    rng = np.random.default_rng(2)
    pose = SE2(0.5, 0.5, 0.1)
    bearings = seen_from(pose, POLES, rng)
    bearings["pole"] = np.append(bearings["pole"], bearings["pole"][0] + 0.9)
    fix = located(bearings, POLES)
    assert (fix.problem, fix.num_used) == ("", 4)
    at = math.degrees(wrap_angle(bearings["pole"][-1]))
    assert fix.left_out == (f"pole at {at:.0f} deg: every pole is seen at another bearing",)
    assert np.abs(difference(fix.estimate.pose, pose)).max() < 0.15


def test_bearings_that_are_no_numbers_are_left_out_and_said() -> None:
    bearings = seen_from(SE2(0.5, 0.5, 0.1), POLES)
    bearings["pole"] = np.append(bearings["pole"], [math.nan, math.inf])
    fix = located(bearings, POLES)
    assert fix.problem == "" and fix.note == "2 bearings are not numbers"
    assert located({"pole": np.full(4, math.nan)}, POLES).problem == "no landmark is seen"


def test_what_the_file_does_not_know_is_said() -> None:
    fix = located({"robots": np.zeros(2)}, POLES)
    assert fix.estimate is None and fix.note == "2 bearings of no known class"


@pytest.mark.parametrize(("num", "words"), [(0, "no landmark"), (1, "one"), (2, "a circle open")])
def test_too_few_landmarks_give_no_pose(num: int, words: str) -> None:
    fix = located({"pole": seen_from(SE2(0.5, 0.5, 0.1), POLES)["pole"][:num]}, POLES)
    assert fix.estimate is None and words in fix.problem


def test_a_pose_whose_covariance_is_no_measure_is_refused() -> None:
    """Near the circle through three posts the squared deviations do not grow as promised."""
    pose = SE2(-2.9, -0.35, -2.2)
    bearings = seen_from(pose, FIELD)
    assert located(bearings).problem == ""
    del bearings["goal_blue_right"]
    fix = located(bearings, config=UNCONFIRMED)
    assert fix.estimate is None and "not known well enough" in fix.problem


def test_a_covariance_is_curved_if_the_bearings_are_poor_and_not_if_they_are_good() -> None:
    pose, marks = SE2(-1.2, 0.4, -2.0), list(POLES["pole"])
    for sd, is_so in ((1e-4, False), (0.3, True)):
        bearings = seen_from(pose, POLES)["pole"]
        seen = [Sighting("pole", float(b), sd) for b in bearings]
        fit = fit_pose(pose, seen, marks)
        assert is_curved(estimate_of(fit), fit.chi2, seen, marks) == is_so


def test_landmarks_and_robot_on_one_line_give_no_pose() -> None:
    line: Landmarks = {k: (Landmark(((x, 0.0),)),) for k, x in (("a", -3.0), ("b", 2.0), ("c", 4))}
    fix = located(seen_from(SE2(0.0, 0.0, 0.4), line), line)
    assert fix.estimate is None and "one line" in fix.problem


def test_landmarks_on_a_line_beside_the_robot_do() -> None:
    line: Landmarks = {k: (Landmark(((x, 0.0),)),) for k, x in (("a", -3.0), ("b", 2.0), ("c", 4))}
    pose = SE2(0.0, 2.0, 0.4)
    fix = located(seen_from(pose, line), line, UNCONFIRMED)
    assert difference(fix.estimate.pose, pose) == pytest.approx(np.zeros(3), abs=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_on_the_circle_through_three_landmarks_no_pose_is_sold(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a = np.array([0.2, 1.5, 3.0])
    ring: Landmarks = {
        f"m{k}": (Landmark(((2.0 * math.cos(v), 2.0 * math.sin(v)),)),) for k, v in enumerate(a)
    }
    pose = SE2(2.0 * math.cos(4.5), 2.0 * math.sin(4.5), 0.3)
    fix = located(seen_from(pose, ring, rng), ring)
    assert fix.estimate is None and fix.problem


@pytest.mark.parametrize("off_m", [0.0, 0.05])
def test_the_same_place_with_another_yaw_is_ambiguous_too(off_m: float) -> None:
    """Four like poles on a square fit four times from its middle, turned by 90 degrees each."""
    square: Landmarks = {
        "pole": tuple(Landmark((p,)) for p in ((2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0), (2.0, -2.0)))
    }
    rng = np.random.default_rng(5)
    for _ in range(20):
        a = rng.uniform(-3.1, 3.1)
        pose = SE2(off_m * math.cos(a), off_m * math.sin(a), rng.uniform(-3.1, 3.1))
        bearings = rng.permutation(seen_from(pose, square, rng)["pole"])
        fix = located({"pole": bearings}, square)
        assert fix.estimate is None and "ambiguous" in fix.problem


def test_one_false_of_three_bearings_is_never_sold() -> None:
    rng = np.random.default_rng(6)
    for _ in range(50):
        bearings = seen_from(random_pose(rng), FIELD, rng)
        del bearings[str(rng.choice(sorted(bearings)))]
        false = str(rng.choice(sorted(bearings)))
        bearings[false] = bearings[false] + rng.choice((-1, 1)) * rng.uniform(0.1, 0.5)
        assert located(bearings).estimate is None


def test_one_false_of_seven_bearings_is_never_sold() -> None:
    """Of unlike poles all round, none nearer than the others: it is left out, or all refused."""
    rng, num_known = np.random.default_rng(6), 0
    for _ in range(50):
        pose = SE2(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-3.1, 3.1))
        bearings = seen_from(pose, ring_of(7), rng)
        false = str(rng.choice(sorted(bearings)))
        bearings[false] = bearings[false] + rng.choice((-1, 1)) * rng.uniform(0.1, 0.5)
        fix = located(bearings, ring_of(7))
        if fix.estimate is not None:
            num_known += 1
            assert normalized_error(fix.estimate.pose, pose, fix.estimate.cov) < 25.0
    assert num_known > 40


def test_three_bearings_are_sent_where_that_is_asked_for_and_it_is_said() -> None:
    pose = SE2(1.0, -0.7, 0.6)
    bearings = seen_from(pose, FIELD)
    del bearings["goal_blue_left"]
    refused = located(bearings)
    assert refused.estimate is None and "min_spare" in refused.problem
    fix = located(bearings, config=UNCONFIRMED)
    assert fix.problem == "" and fix.note == "nothing confirms it"
    assert difference(fix.estimate.pose, pose) == pytest.approx(np.zeros(3), abs=1e-6)
    assert located(seen_from(pose, FIELD), config=UNCONFIRMED).note == ""


def test_bearings_of_twice_the_stated_deviation_are_told_by_their_sum() -> None:
    """Each of many poles is within its gate; together they are not what the deviation promises."""
    ring, pose, rng = ring_of(16), SE2(0.4, -0.2, 1.0), np.random.default_rng(7)
    fixes = [located(seen_from(pose, ring, rng, 2.2 * SD), ring) for _ in range(20)]
    refused = [fix for fix in fixes if fix.estimate is None]
    assert len(refused) > 12
    assert all("as much as bearing_sd_rad" in fix.problem for fix in refused)
    true = [located(seen_from(pose, ring, rng), ring) for _ in range(20)]
    assert sum(fix.estimate is None for fix in true) <= 1


@pytest.mark.parametrize(("num_false", "is_known"), [(6, True), (7, False)])
def test_less_than_half_of_what_is_seen_is_no_place(num_false: int, is_known: bool) -> None:
    """Six poles are where they should be; lamps are seen where none can be."""
    pose = SE2(1.0, -0.5, 2.0)
    with_lamp: Landmarks = {**ring_of(6), "lamp": (Landmark(((0.0, -9.0),)),)}
    bearings = seen_from(pose, with_lamp)
    bearings["lamp"] = bearings["lamp"] + 0.4 + 0.1 * np.arange(num_false)
    fix = located(bearings, with_lamp)
    assert (fix.estimate is not None) == is_known
    no_place = "the bearings contradict each other: no place fits most of them"
    assert fix.problem == ("" if is_known else no_place)


def test_a_place_of_two_like_ends_is_ambiguous() -> None:
    like: Landmarks = {
        "pole": tuple(Landmark((p,)) for p in ((4.0, 1.0), (4.0, -1.0), (-4.0, 1.0), (-4.0, -1.0)))
    }
    fix = located(seen_from(SE2(1.0, 0.5, 0.3), like), like)
    assert fix.estimate is None and "ambiguous" in fix.problem


def test_bearings_of_nowhere_give_no_pose() -> None:
    bearings = {kind: np.array([0.1 * k]) for k, kind in enumerate(reversed(ENDS))}
    fix = located({**bearings, "goal_yellow_left": np.array([3.0])}, ENDS)
    assert fix.estimate is None and fix.problem


def test_two_landmarks_with_distances_give_a_pose() -> None:
    pose, rng = SE2(1.0, -0.5, 2.0), np.random.default_rng(3)
    off = []
    for _ in range(200):
        seen = [
            Sighting(
                s.kind, s.bearing, s.bearing_sd,
                float(np.hypot(*(FIELD[s.kind][0].point_seen(np.array([1.0, -0.5])) - [1.0, -0.5])))
                + rng.normal(0, 0.1), 0.1,
            )
            for s in sightings_of(seen_from(pose, ENDS, rng), CONFIG)[::2]
        ]  # fmt: skip
        fix = LandmarkLocator(FIELD, CONFIG).locate(seen)
        if fix.estimate is not None:
            off.append(normalized_error(fix.estimate.pose, pose, fix.estimate.cov))
    assert len(off) > 196  # one in a thousand is refused for contradicting
    assert np.mean(off) == pytest.approx(3.0, abs=4.0 * math.sqrt(6.0 / 200))


def test_one_distance_is_not_enough_for_two_posts_of_a_goal_but_with_a_third_bearing() -> None:
    pose = SE2(1.0, -0.5, 2.0)
    seen = sightings_of(seen_from(pose, ENDS), CONFIG)
    d = float(np.hypot(*(FIELD[seen[0].kind][0].point_seen(np.array([1.0, -0.5])) - [1.0, -0.5])))
    far = Sighting(seen[0].kind, seen[0].bearing, SD, d, 0.05)
    open_fix = LandmarkLocator(FIELD, CONFIG).locate([far, seen[1]])
    assert open_fix.estimate is None and open_fix.problem
    fix = LandmarkLocator(FIELD, CONFIG).locate([far, seen[1], seen[2]])
    assert difference(fix.estimate.pose, pose) == pytest.approx(np.zeros(3), abs=1e-5)


def test_distances_to_what_stands_before_do_not_spoil_the_pose() -> None:
    """All feet are hidden alike, as by a mask that ends at the robot's own body."""
    pose = SE2(-0.9, -1.2, 0.7)
    seen = sightings_of(seen_from(pose, ENDS), CONFIG)
    near = [Sighting(s.kind, s.bearing, SD, 0.6, 0.035) for s in seen]
    fix = LandmarkLocator(FIELD, CONFIG).locate(near)
    assert difference(fix.estimate.pose, pose) == pytest.approx(np.zeros(3), abs=1e-5)


def test_one_of_four_that_contradicts_leaves_nothing_to_confirm_the_rest() -> None:
    bearings = seen_from(SE2(-0.9, -1.2, 0.7), ENDS)
    bearings["goal_blue_left"] = bearings["goal_blue_left"] + 0.3
    for config in (CONFIG, UNCONFIRMED):
        fix = located(bearings, ENDS, config)
        assert fix.estimate is None and "nothing confirms those that do" in fix.problem


def test_a_start_far_off_still_ends_at_the_pose() -> None:
    pose = SE2(1.0, -0.5, 2.0)
    seen = sightings_of(seen_from(pose, ENDS), CONFIG)
    fit = fit_pose(SE2(0.0, 0.0, 1.2), seen, [FIELD[s.kind][0] for s in seen])
    assert fit is not None
    assert difference(fit.pose, pose) == pytest.approx(np.zeros(3), abs=1e-6)
