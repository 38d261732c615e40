"""From sightings to a pose: right, consistent, or refused with a reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import Sighting, fit_pose, residuals
from multi_localizer.landmark_locator import LandmarkLocator, sightings_of
from multi_localizer.landmarks import Landmark, Landmarks, load_landmarks
from multi_localizer.pose_estimate import difference, normalized_error

CONFIG = LandmarkConfig()
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


def located(bearings: dict[str, np.ndarray], landmarks: Landmarks = FIELD):
    return LandmarkLocator(landmarks, CONFIG).locate(sightings_of(bearings, CONFIG))


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
    assert (fix.problem, fix.num_used, fix.num_left_out) == ("", 4, 1)
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


def test_landmarks_and_robot_on_one_line_give_no_pose() -> None:
    line: Landmarks = {k: (Landmark(((x, 0.0),)),) for k, x in (("a", -3.0), ("b", 2.0), ("c", 4))}
    fix = located(seen_from(SE2(0.0, 0.0, 0.4), line), line)
    assert fix.estimate is None and "one line" in fix.problem


def test_landmarks_on_a_line_beside_the_robot_do() -> None:
    line: Landmarks = {k: (Landmark(((x, 0.0),)),) for k, x in (("a", -3.0), ("b", 2.0), ("c", 4))}
    pose = SE2(0.0, 2.0, 0.4)
    fix = located(seen_from(pose, line), line)
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
        off.append(normalized_error(fix.estimate.pose, pose, fix.estimate.cov))
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
    bearings["goal_blue_left"] = bearings["goal_blue_left"] + 0.1
    fix = located(bearings, ENDS)
    assert fix.estimate is None and fix.problem


def test_a_start_far_off_still_ends_at_the_pose() -> None:
    pose = SE2(1.0, -0.5, 2.0)
    seen = sightings_of(seen_from(pose, ENDS), CONFIG)
    fit = fit_pose(SE2(0.0, 0.0, 1.2), seen, [FIELD[s.kind][0] for s in seen])
    assert fit is not None
    assert difference(fit.pose, pose) == pytest.approx(np.zeros(3), abs=1e-6)
