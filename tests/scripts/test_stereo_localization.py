"""The judge of the stereo localization: figures by hand, twins, the drive, the room's cameras."""

from __future__ import annotations

import math

import numpy as np
import pytest

from experiments.stereo_drive import Step, drive_poses, drive_values, odometry_steps
from experiments.stereo_localization_judge import look_alike_values, summarized
from experiments.stereo_look_alike import LookAlikes
from experiments.stereo_places import TRUE, Observer, cameras_of
from experiments.stereo_views import GAP_M, StereoRoom, edge_points
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import VoxelScene


@pytest.fixture(scope="module")
def room():
    return StereoRoom(0)


def found(x, y, yaw, state="known"):
    pose = [0.0, 0.0, 0.0]
    return {
        "pose": pose,
        "state": state,
        "x_m": x,
        "y_m": y,
        "yaw_rad": yaw,
        "ms": 5.0,
        "nees": 4.0 * x,
    }


def test_figures_by_hand():
    nothing = {"pose": None, "state": "lost", "x_m": None, "y_m": None, "yaw_rad": None, "ms": 7.0}
    nothing["nees"] = None
    rows = [found(0.06, 0.05, 0.01), found(0.06, 0.06, 0.03), found(2.0, 0.0, 0.02, "ambiguous")]
    got = summarized([{"found": {"m": row}} for row in (*rows, nothing)], "m")
    assert (got["within_8cm"], got["over_1m"], got["known"]) == (25.0, 25.0, 50.0)
    assert got["known_within_8cm"] == 50.0 and got["median_ms"] == 5.0
    assert got["mean_nees"] == pytest.approx(0.24)  # of the two that are known
    assert got["mean_x_cm"] == pytest.approx(100 * 2.12 / 3)
    assert got["mean_y_cm"] == pytest.approx(100 * 0.11 / 3)
    assert got["mean_theta_deg"] == pytest.approx(math.degrees(0.02))
    none = summarized([{"found": {"m": nothing}}], "m")
    assert none["within_8cm"] == 0.0 and none["mean_x_cm"] is None


def test_noise_is_what_the_score_varies_by():
    places = [{"score": s, "twin_score": t} for s, t in ((0.1, 0.05), (0.3, 0.15), (0.2, 0.5))]
    got = look_alike_values(places)
    assert got["noise"] == pytest.approx(math.sqrt(0.02 / 3))
    assert got["share"] == pytest.approx(100 / 3)
    assert got["share_below_mean_score"] == pytest.approx(200 / 3)


def _symmetric_map(mark: bool) -> VoxelMap:
    """Return a room of 4 x 4 m that looks the same after half a turn, or not with a mark."""
    occupied = np.zeros((4, 80, 80), dtype=bool)
    occupied[0] = occupied[-1] = True
    occupied[:, 0] = occupied[:, -1] = occupied[:, :, 0] = occupied[:, :, -1] = True
    color = np.full((*occupied.shape, 3), 120, dtype=np.uint8)
    noise = np.random.default_rng(0).integers(40, 250, (80, 3)).astype(np.uint8)
    color[:, :, 0], color[:, ::-1, -1] = noise, noise
    color[:, 0, :], color[:, -1, ::-1] = noise[::-1], noise[::-1]
    if mark:
        color[1:3, :, 0] = (250, 0, 0)
    color[~occupied] = 0
    return VoxelMap(color, occupied, 0.05, 0.5, 0.0, 0.0, 0.0)


def test_the_twin_of_a_place_is_found_across_the_room(room):
    pose = SE2(1.1, 1.7, 0.3)
    scores = []
    for mark in (False, True):
        alike = LookAlikes(VoxelScene(_symmetric_map(mark)), cameras_of(room))
        twin = alike.twin(pose)
        assert math.hypot(twin.pose.x - pose.x, twin.pose.y - pose.y) > 1.0
        scores.append(twin.score)
        if not mark:
            assert (twin.pose.x, twin.pose.y) == pytest.approx((2.9, 2.3), abs=0.011)
    assert scores[0] < 0.01 < scores[1]


def test_the_drive_is_as_long_as_asked_and_clear_of_everything(room):
    poses = drive_poses(50.0)
    steps = [a.inverse() @ b for a, b in zip(poses[:-1], poses[1:], strict=True)]
    lengths = np.array([math.hypot(s.x, s.y) for s in steps])
    assert lengths.sum() == pytest.approx(50.0, abs=0.1) and lengths.std() < 4e-4
    assert max(abs(s.yaw) for s in steps) < 0.1
    assert min(room.gap(pose) for pose in poses[::5]) >= GAP_M


def test_odometry_is_off_by_what_is_said():
    poses = drive_poses(40.0)
    steps = odometry_steps(poses, np.random.default_rng(0))
    ratios = np.array([s.x / 0.04 for s in steps])
    assert ratios.mean() == pytest.approx(1.02, abs=0.01)
    assert ratios.std() == pytest.approx(0.05, abs=0.01)


def test_figures_of_a_drive():
    def step(x, state):
        estimate = PoseEstimate(SE2(x, 0.0, 0.0), np.eye(3))
        hypotheses = () if x is None else (StereoHypothesis(estimate, 1.0, 0.1),)
        return Step(SE2(0.0, 0.0, 0.0), StereoPose(state, hypotheses), 3.0)

    known, lost = StereoState.KNOWN, StereoState.LOST
    got = drive_values([step(0.05, known), step(0.6, StereoState.AMBIGUOUS), step(0.1, lost)])
    assert (got["steps"], got["lost_steps"], got["ambiguous_steps"]) == (3, 1, 1)
    assert (got["far_off_steps"], got["max_cm"]) == (1, pytest.approx(60.0))
    assert got["median_cm"] == pytest.approx(10.0) and got["within_8cm"] == pytest.approx(100 / 3)


def test_cameras_look_both_ways_from_the_mast(room):
    front, rear = cameras_of(room)
    assert (front.x_m, front.y_m, front.height_m, front.yaw) == pytest.approx((-0.11, 0.05, 1, 0))
    assert (rear.x_m, rear.y_m) == pytest.approx((-0.18, -0.05))
    assert abs(rear.yaw) == pytest.approx(math.pi)
    assert room.baseline_m == pytest.approx(0.10) and room.fov_rad == pytest.approx(math.pi / 3)
    assert room.focal_px * room.baseline_m / 64 == pytest.approx(0.43, abs=0.01)


def test_what_is_seen_is_what_the_map_shows_there(room):
    """True distances of the room against the map of its solids, at one place, both pairs."""
    from experiments.stereo_world_map import map_of_world

    observer = Observer(room, (TRUE,))
    pose = SE2(2.2, 2.4, 0.3)
    place = observer.look(pose, 0)
    scene = VoxelScene(map_of_world("stereo_room", 0.02, 0.16))
    for view, camera in zip(place.views[TRUE], observer.cameras, strict=True):
        _, distance = scene.render(np.array([[2.2, 2.4, 0.3]]), camera, (320, 8))
        assert np.median(np.abs(distance[0] - view.distance)) < 0.02
    true = 276.27 * 0.1 / observer.disparity(TRUE, place.seen["front"])
    assert true == pytest.approx(place.seen["front"].depth, rel=1e-3)


def test_an_outline_has_points_along_its_edges():
    points = edge_points(np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]]), 0.05)
    assert len(points) == 2 + 2 + 3 and (points[1] == (0.05, 0.0)).all()


def test_a_map_is_made_from_what_the_robot_sees(room, tmp_path, monkeypatch):
    """Three places with true distances: what they see of the room's walls is in the map."""
    from experiments import stereo_map_views
    from multi_localizer.voxel_map import load_voxel_map

    monkeypatch.setattr(stereo_map_views, "NUM_PLACES", 3)
    path = tmp_path / "map.npz"
    stereo_map_views.map_of_views(tmp_path / "views", path, room, False, 0)
    made = load_voxel_map(path)
    assert made.size_m == pytest.approx((5.14, 5.14, 2.88), abs=0.2)
    layers, rows, columns = np.nonzero(made.occupied[3:14])  # between floor and ceiling
    x = made.origin_x_m + (columns + 0.5) * made.cell_m
    y = made.origin_y_m + (rows + 0.5) * made.cell_m
    gaps = np.min([s.signed_distance(np.column_stack((x, y))) for s in room.solids], axis=0)
    assert len(layers) > 5000 and np.mean(gaps < 0.015) > 0.97
