"""The judge of the stereo experiment: true distances, regions, shares of bad pixels."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from experiments.stereo_measures import DepthErrors, changing, depth_of
from experiments.stereo_pairs import Pair, judge, judge_all, match_padded, read_pair, tuned_sgbm
from experiments.stereo_views import StereoRoom, room_depth
from floornav_common.reporting import UserError
from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

NAN = np.nan


def test_true_distances_by_hand():
    box = Solid("box", SE2(3.0, 0.0, 0.0), (1.0, 1.0, 2.0), 0.0, False, (0, 0, 0))
    can = Solid("can", SE2(0.0, 4.0, 0.0), (1.0, 1.0, 2.0), 0.0, True, (0, 0, 0))
    rays = np.array(
        [[1, 0, 0], [0, 2, 0], [0, 0, -1], [0, 0, 1], [-1, 0, -0.5], [1, 0, 1]], dtype=float
    )
    depth = room_depth(np.array([0.0, 0.0, 1.0]), rays, [box, can], 2.5)
    assert depth.tolist() == pytest.approx([2.5, 1.75, 1.0, 1.5, 2.0, 1.5])


def test_a_turned_box_is_met_at_its_corner():
    box = Solid("box", SE2(3.0, 0.0, math.pi / 4), (1.0, 1.0, 2.0), 0.0, False, (0, 0, 0))
    depth = room_depth(np.array([0.0, 0.0, 1.0]), np.array([[1.0, 0.0, 0.0]]), [box], 3.0)
    assert depth[0] == pytest.approx(3.0 - math.sqrt(0.5))


def test_pixels_of_both_images_show_the_same_point_at_the_true_distance():
    room = StereoRoom(0)
    view = room.view(SE2(2.2, 2.4, 0.3), 0)
    shift = room.focal_px * room.baseline_m / view.depth
    v, u = np.mgrid[: shift.shape[0], : shift.shape[1]].astype(np.float32)

    def difference(off):
        warped = cv2.remap(view.right, (u - shift + off).astype(np.float32), v, cv2.INTER_LINEAR)
        return np.abs(warped.astype(int) - view.left)[:, 64:].mean()

    assert difference(0.0) < 0.95 * min(difference(-1.0), difference(1.0))


def test_regions_that_change_lie_within_8_px_of_an_edge():
    depth = np.full((1, 40), 2.0)
    depth[0, 20:] = 2.33
    assert np.flatnonzero(changing(depth)[0]).tolist() == list(range(12, 28))
    depth[0, 20:] = 2.31
    assert not changing(depth).any()


def test_nothing_is_farther_than_the_room():
    disparities = np.array([[10.0, NAN, 0.0, 5.0]], dtype=np.float32)
    assert depth_of(disparities, 100.0, 0.1, 7.0).tolist() == [[1.0, 7.0, 7.0, 2.0]]


def test_errors_of_both_regions_add_up():
    depth = np.full((1, 40), 2.0)
    depth[0, 20:] = 3.0
    errors = DepthErrors()
    errors.add(np.zeros((1, 40), np.float32), depth + np.r_[np.full(16, 0.1), np.zeros(24)], depth)
    got = errors.as_dict()
    assert got["mean_cm"] == pytest.approx(100 * 16 * 0.1 / 40)
    assert got["changing_cm"] == pytest.approx(100 * 4 * 0.1 / 16)
    assert got["smooth_cm"] == pytest.approx(100 * 12 * 0.1 / 24)
    assert errors.changing_share == pytest.approx(40.0)


def test_a_pixel_without_a_value_is_bad_and_one_without_truth_does_not_count():
    truth = np.array([[5.0, 5.0, 5.0, 5.0, NAN]], dtype=np.float32)
    found = np.array([[5.5, 6.5, 9.0, NAN, 40.0]], dtype=np.float32)
    got = judge(found, truth)
    assert (got["bad1"], got["bad2"]) == (75.0, 50.0)
    assert (got["valid"], got["bad1_valid"]) == (75.0, pytest.approx(200.0 / 3.0))
    assert got["mean_px"] == pytest.approx((0.5 + 1.5 + 4.0 + 4.0) / 4.0)


def shifted_noise():
    """A pair with a near square before a wall: what it hides from the right camera has no value."""
    rng = np.random.default_rng(0)
    wide = rng.integers(0, 256, (60, 140, 3), dtype=np.uint8)
    truth = np.full((60, 120), 4.0, np.float32)
    left, right = wide[:, :120].copy(), wide[:, 4:124].copy()
    near = rng.integers(0, 256, (30, 40, 3), dtype=np.uint8)
    left[15:45, 50:90], right[15:45, 38:78], truth[15:45, 50:90] = near, near, 12.0
    return Pair(left, right, truth)


def test_holes_are_judged_as_found_and_filled_for_every_method(monkeypatch):
    monkeypatch.setattr("experiments.stereo_pairs.tuned_sgbm", lambda *_: {})
    found = {name: measures for name, measures, _ in judge_all(shifted_noise(), 32)}
    assert list(found)[-1] == "ours_with_holes"
    assert found["ours"]["valid"] == 100.0 > found["ours_with_holes"]["valid"]
    for name in ("bad1_filled", "bad2_filled", "mean_px"):
        assert found["ours"][name] == found["ours_with_holes"][name]
    assert found["ours"]["bad1"] == found["ours"]["bad1_filled"]
    holes = found["ours_with_holes"]
    assert holes["bad1"] >= 100.0 - holes["valid"] > 0.0


def test_sgbm_is_tuned_for_the_column_it_stands_in():
    grid = {"blockSize": (1, 3, 5), "P1": (8,), "P2": (32,), "disp12MaxDiff": (1, 1000)}
    pair = shifted_noise()
    best = tuned_sgbm(pair, 32, grid)
    as_found, filled = (judge(best[ending][1], pair.truth) for ending in ("", "_filled"))
    assert as_found["bad1"] <= filled["bad1"] and filled["bad1_filled"] <= as_found["bad1_filled"]
    assert best[""][0]["disp12MaxDiff"] == 1000  # without the check there are fewer holes


def test_a_pair_is_widened_for_the_search_and_cut_again(tmp_path):
    image = np.arange(60, dtype=np.uint8).reshape(3, 20)
    for name in ("left", "right", "truth"):
        cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    files = [str(tmp_path / f"{name}.png") for name in ("left", "right", "truth")]
    pair = read_pair(*files, scale=4.0)
    assert np.isnan(pair.truth[0, 0]) and pair.truth[0, 6] == 1.5
    found = match_padded(lambda left, right: left[..., 0] + 0.0 * right[..., 0], pair, 16)
    assert np.array_equal(found, image)


def test_files_that_are_no_pair_are_refused(tmp_path):
    small, large = str(tmp_path / "small.png"), str(tmp_path / "large.png")
    cv2.imwrite(small, np.ones((3, 4), np.uint8))
    cv2.imwrite(large, np.ones((3, 5), np.uint8))
    with pytest.raises(UserError, match="one size"):
        read_pair(small, large, small, 1.0)
    with pytest.raises(UserError, match="no image"):
        read_pair(small, str(tmp_path / "none.png"), small, 1.0)
