"""Masks in, poses out: where the camera sits, sizes, and masks that are no field's."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from floor_masks import alcoves, mask_of, rectangle, small_camera

from floornav_common.camera_files import load_camera_model
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_fitter import FloorFit, FloorShapeFitter
from multi_localizer.floor_localizer import FloorLocalizer
from multi_localizer.floor_node_config import FloorPoseConfig
from multi_localizer.floor_plan import load_plan
from multi_localizer.floor_tracker import TrackState
from multi_localizer.goal_evidence import GoalsSeen
from multi_localizer.pose_estimate import PoseEstimate, difference

CAMERA = load_camera_model("soccer_small_size")
PLAN = load_plan("small_size_field")
COV = np.diag([0.005, 0.005, 0.005]) ** 2
BASE, MOUNT = SE2(0.4, -0.2, 0.7), SE2(0.05, 0.02, 0.3)
TOL_M = 1e-9
PIXELS = np.stack(np.meshgrid(np.arange(256.0), np.arange(220.0)), axis=-1)
SEEN = CAMERA.floor_points(PIXELS)
IS_FLOOR = np.isfinite(SEEN).all(axis=-1)


@dataclass
class FakeFitter:
    """Answers with what it was told, and remembers what it was asked."""

    camera: FloorCamera
    answer: FloorFit
    guesses: list[PoseEstimate | None] = field(default_factory=list)

    def fit(self, mask: np.ndarray, guess: PoseEstimate | None = None) -> FloorFit:
        self.guesses.append(guess)
        return self.answer


def fits(*poses: SE2, problem: str = "") -> FloorFit:
    return FloorFit(tuple(PoseEstimate(p, COV) for p in poses), 100, 0.3, 0.1, problem)


def with_fake(answer: FloorFit) -> tuple[FloorLocalizer, list[FakeFitter]]:
    made: list[FakeFitter] = []

    def make(camera, plan, config) -> FakeFitter:
        made.append(FakeFitter(camera, answer))
        return made[-1]

    return FloorLocalizer(CAMERA, PLAN, FloorPoseConfig(), make), made


def mask_where(is_inside: np.ndarray) -> np.ndarray:
    return np.where(is_inside & IS_FLOOR, 255, 0).astype(np.uint8)


def test_the_pose_is_that_of_base_link_wherever_the_camera_sits() -> None:
    localizer, _ = with_fake(fits(BASE @ MOUNT))
    for k in range(3):
        localizer.take_mask(k, mask_where(IS_FLOOR), MOUNT, None)
    assert difference(localizer.tracker.estimate.pose, BASE) == pytest.approx(0.0, abs=TOL_M)


def test_the_fit_begins_where_the_motion_has_the_camera() -> None:
    localizer, made = with_fake(fits(BASE @ MOUNT))
    step, odometry = SE2(0.1, 0.0, 0.2), SE2(5.0, 2.0, -1.0)
    for k in range(3):
        localizer.take_mask(k * 100_000_000, mask_where(IS_FLOOR), MOUNT, odometry)
    localizer.take_mask(300_000_000, mask_where(IS_FLOOR), MOUNT, odometry @ step)
    *first, last = made[0].guesses
    assert first == [None, None, None]  # until masks agree each looks for all that fits
    assert difference(last.pose, BASE @ step @ MOUNT) == pytest.approx(0.0, abs=1e-6)


def test_with_rivals_every_mask_looks_for_all_that_fits() -> None:
    localizer, made = with_fake(fits(BASE, SE2(0.1, 0.1, 2.0), SE2(-0.3, 0.1, -2.0)))
    for k in range(6):
        localizer.take_mask(k * 100_000_000, mask_where(IS_FLOOR), SE2.identity(), SE2.identity())
    assert made[0].guesses == [None] * 6


def test_how_well_each_pose_fits_is_handed_on() -> None:
    answer = replace(fits(BASE, SE2(-0.3, 0.1, -2.0)), costs=(0.1, 0.6))
    localizer, _ = with_fake(answer)
    for k in range(8):
        localizer.take_mask(k * 100_000_000, mask_where(IS_FLOOR), SE2.identity(), SE2.identity())
    assert localizer.tracker.state is TrackState.KNOWN


@pytest.mark.parametrize(
    ("is_first_only", "cost", "is_known"),
    [(False, 0.54, True), (False, 0.7, False), (True, 0.54, True), (True, 0.7, False)],
)
def test_the_pose_is_not_known_before_a_mask_that_most_of_the_border_fits(
    is_first_only: bool, cost: float, is_known: bool
) -> None:
    good = replace(fits(BASE), costs=(0.2,))
    bad = replace(good, first_cost=cost) if is_first_only else replace(good, costs=(cost,))
    localizer, made = with_fake(bad)

    def take(num: int) -> None:
        for _ in range(num):
            stamp_ns = (localizer.tracker.stamp_ns or 0) + 100_000_000
            localizer.take_mask(stamp_ns, mask_where(IS_FLOOR), SE2.identity(), SE2.identity())

    take(8)
    assert (localizer.tracker.state is TrackState.KNOWN) is is_known
    assert ("has not fitted" in localizer.tracker.reason) is not is_known
    made[0].answer = good
    take(3)
    assert localizer.tracker.state is TrackState.KNOWN
    made[0].answer = bad  # people come: what is known stays known
    take(8)
    assert localizer.tracker.state is TrackState.KNOWN


def test_a_person_who_says_where_it_is_is_believed_though_most_of_the_border_is_hidden() -> None:
    localizer, _ = with_fake(replace(fits(BASE), costs=(0.7,)))
    localizer.tracker.relocate(PoseEstimate(BASE, COV))
    for k in range(4):
        localizer.take_mask(k * 100_000_000, mask_where(IS_FLOOR), SE2.identity(), SE2.identity())
    assert localizer.tracker.state is TrackState.KNOWN


@pytest.mark.parametrize(
    ("pose", "state", "word"),
    [
        (SE2(4.4, 1.38, 0.4), TrackState.OPEN, "poses fit alike"),
        (SE2(6.76108, 0.18170, -1.86489), TrackState.OPEN, "has not fitted"),
        (SE2(6.84634, 0.16500, -1.82401), TrackState.KNOWN, ""),
    ],
    ids=["one of seven like alcoves", "not found: floor behind walls", "in view of an end"],
)
def test_a_corridor_of_like_alcoves_is_known_where_it_can_be(
    pose: SE2, state: TrackState, word: str
) -> None:
    camera, plan = small_camera(), alcoves()
    localizer = FloorLocalizer(camera, plan, FloorPoseConfig())
    mask = mask_of(camera, plan, pose)
    for k in range(8):
        localizer.take_mask(k * 100_000_000, mask, SE2.identity(), SE2.identity())
    assert localizer.tracker.state is state and word in localizer.tracker.reason
    if state is TrackState.KNOWN:
        assert np.abs(difference(localizer.tracker.estimate.pose, pose)).max() < 0.02


def test_the_fitter_says_how_much_of_the_border_fits() -> None:
    with np.errstate(invalid="ignore"):
        mask = mask_where((np.abs(SEEN - (0.1, 0.05)) < (1.4, 0.8)).all(axis=-1))
    fit = FloorShapeFitter(CAMERA, rectangle(2.8, 1.6)).fit(mask)
    assert len(fit.candidates) == len(fit.costs) == 2
    assert fit.costs[0] == fit.costs[1] < 0.1


def test_masks_of_another_size_are_those_of_the_resized_camera() -> None:
    localizer, made = with_fake(fits(BASE))
    localizer.take_mask(0, np.zeros((440, 512), np.uint8), MOUNT, None)
    assert (made[0].camera.width_px, made[0].camera.height_px) == (512, 440)
    assert made[0].camera.position_m == (0.0, 0.0)  # where it sits comes from TF
    with pytest.raises(ValueError, match="to 15"):
        localizer.take_mask(1, np.zeros((100, 500), np.uint8), MOUNT, None)


def test_a_new_tuning_makes_a_new_fitter() -> None:
    localizer, made = with_fake(fits(BASE))
    localizer.take_mask(0, mask_where(IS_FLOOR), MOUNT, None)
    localizer.reconfigure(FloorPoseConfig())
    localizer.take_mask(1, mask_where(IS_FLOOR), MOUNT, None)
    assert len(made) == 2


def two_blobs() -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return mask_where((np.abs(SEEN[..., 1]) > 0.3) & (np.abs(SEEN) < 0.6).all(axis=-1))


def corridor() -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return mask_where(np.abs(SEEN[..., 1]) < 0.4)


@pytest.mark.parametrize(
    "mask",
    [np.zeros((220, 256), np.uint8), two_blobs(), corridor(), mask_where(IS_FLOOR)],
    ids=["empty", "two blobs", "a corridor without ends", "floor as far as can be seen"],
)
def test_a_mask_that_is_not_of_the_field_gives_no_pose_but_a_reason(mask: np.ndarray) -> None:
    """By the real fitter; goals that are seen make nothing out of it."""
    localizer = FloorLocalizer(CAMERA, PLAN, FloorPoseConfig())
    for k in range(5):
        localizer.take_mask(k * 100_000_000, mask, SE2.identity(), SE2.identity())
        seen = GoalsSeen("goal_blue", k * 100_000_000, np.array([0.3]), SE2.identity())
        localizer.tracker.see_goals(seen)
        assert localizer.tracker.estimate is None
    assert localizer.tracker.state is TrackState.LOST and localizer.tracker.reason


def test_noise_gives_no_pose() -> None:
    rng = np.random.default_rng(0)
    localizer = FloorLocalizer(CAMERA, PLAN, FloorPoseConfig())
    mask = mask_where(rng.random(IS_FLOOR.shape) < 0.5)
    localizer.take_mask(0, mask, SE2.identity(), None)
    assert localizer.tracker.estimate is None and not math.isnan(localizer.newest.hidden_share)
