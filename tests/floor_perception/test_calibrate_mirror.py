"""The command from its input to its camera file, and what it says of input that is not right."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from floor_perception.board_view import view_pixels
from floor_perception.calibrate_mirror import main
from floor_perception.calibration_input import read_gray, read_table
from floor_perception.checkerboard import board_points, find_corners, find_edge
from floor_perception.mirror_fit import fit_mirror
from floornav_common.calibration import STEP, moved_cameras
from floornav_common.camera_files import load_camera, load_floor_camera
from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera, paper_camera
from floornav_common.cameras.radius_table import RadiusTableCamera
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera
from floornav_common.reporting import UserError

REAL = Path(__file__).resolve().parents[3] / "shared" / "data" / "paracatadioptric"
DISTANCES = np.array([0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0])
INTRINSICS = np.array([1.0, 150.0, 150.0, 322.0, 238.0, 0.0, 0.0, 0.0, 0.0, 0.0])
BOARD_POSES = (
    (0.1, 0.5, 0.1, 1.0, -3.0, 7.0), (0.5, -0.4, 1.0, -3.0, -3.0, 6.0),
    (-0.6, 0.2, 0.3, -5.0, -2.0, 6.0), (0.4, 0.1, 1.2, 3.0, -4.0, 5.5),
    (0.2, -0.5, 2.0, 3.0, 1.0, 6.0),
)  # fmt: skip


def pairs_file(path: Path, sd_px: float = 0.0) -> Path:
    R = paper_camera().floor_radius(DISTANCES)
    R = R + np.random.default_rng(0).normal(0.0, sd_px, len(R))
    rows = [f"{a:.4f}, {b * 1000:.0f}  # by tape" for a, b in zip(R, DISTANCES, strict=True)]
    path.write_text("# a mirror\nradius_px, distance_mm\n" + "\n".join(rows) + "\n")
    return path


def board_picture(pose: tuple[float, ...]) -> np.ndarray:
    """Return a round picture (480, 640) of a 6 x 8 board: its squares drawn as curved polygons."""
    scale = 4
    image = np.full((480 * scale, 640 * scale), 20, np.uint8)
    cv2.circle(image, (322 * scale, 238 * scale), 220 * scale, 120, -1)

    def fill(x: float, y: float, size_x: float, size_y: float, gray: int) -> None:
        t = np.linspace(0.0, 1.0, 9)[:-1]
        edge = np.concatenate(
            [
                np.stack(s, 1)
                for s in ((t, 0 * t), (1 + 0 * t, t), (1 - t, 1 + 0 * t), (0 * t, 1 - t))
            ]
        )
        pixels = view_pixels(INTRINSICS, np.array(pose), edge * (size_x, size_y) + (x, y))
        corners = np.rint(((pixels + 0.5) * scale - 0.5) * 16).astype(np.int32)
        cv2.fillPoly(image, [corners], gray, cv2.LINE_AA, 4)

    fill(-1.6, -1.6, 8.2, 10.2, 235)
    for x in range(-1, 6):
        for y in range(-1, 8):
            if (x + y) % 2 == 0:
                fill(x, y, 1.0, 1.0, 25)
    return cv2.GaussianBlur(
        cv2.resize(image, (640, 480), interpolation=cv2.INTER_AREA), (0, 0), 0.6
    )


def board_folder(folder: Path) -> Path:
    folder.mkdir()
    for k, pose in enumerate(BOARD_POSES):
        cv2.imwrite(str(folder / f"board_{k}.png"), board_picture(pose))
    return folder


def test_pairs_become_the_mirror_of_equation_26(tmp_path: Path) -> None:
    table, out = pairs_file(tmp_path / "pairs.csv", 0.1), tmp_path / "out"
    assert main([str(table), "--image-size", "256", "220", "--out", str(out), "--quiet"]) == 0
    floor = load_floor_camera(out / "camera.yaml")
    assert isinstance(floor.camera, MirrorCamera)
    at = np.array([60.0, 80.0, 100.0])
    assert np.allclose(floor.floor_distance(at), [0.305, 0.582, 1.621], rtol=0.02)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["ok"] and summary["job"] == "pairs" and summary["rms_px"] < 0.2
    assert summary["parameters"]["xi"]["low"] < 0.973 < summary["parameters"]["xi"]["high"]
    assert any("trade off" in text for text in summary["warnings"])
    assert (out / "report.html").exists() and (out / "residuals.png").exists()


def test_the_camera_file_says_how_well_the_mirror_is_known(tmp_path: Path) -> None:
    """What the cameras beside it see scatters as the fit says r = f(R) does."""
    table, out = pairs_file(tmp_path / "pairs.csv", 0.1), tmp_path / "out"
    options = ["--image-size", "256", "220", "--quiet", "--center-sd", "0.2"]
    for kind in ("unified", "hyperboloidal_mirror"):
        assert main([str(table), *options, "--kind", kind, "--out", str(out / kind)]) == 0
        floor = load_floor_camera(out / kind / "camera.yaml")
        assert floor.calibration is not None
        names, cov = list(floor.calibration.names), np.array(floor.calibration.cov)
        k = names.index("center_u_px")
        assert cov[k, k] == pytest.approx(0.04)
        pixel = np.array(floor.center_px) + (0.0, -100.0)
        moves = [(a.floor_points(pixel) - b.floor_points(pixel)) / (2.0 * STEP)
                 for a, b in moved_cameras(floor)]  # fmt: skip
        own = replace(floor, calibration=None)
        slope = own.floor_jacobian(pixel)
        by_center = 0.2**2 * slope @ slope.T
        table_read = read_table(table)
        fit = fit_mirror(table_read.pixels, table_read.metres)
        radial = float(fit.floor_distance(np.array([100.0])).cov[0, 0])
        spread = np.array(moves).T @ np.array(moves)
        way = floor.floor_points(pixel) / np.hypot(*floor.floor_points(pixel))
        assert way @ (spread - by_center) @ way == pytest.approx(radial, rel=0.02)


@pytest.mark.parametrize(
    ("kind", "made"), [("unified", UnifiedCamera), ("radius_table", RadiusTableCamera)]
)
def test_pairs_become_other_kinds(tmp_path: Path, kind: str, made: type) -> None:
    table, out = pairs_file(tmp_path / "pairs.csv"), tmp_path / "out"
    size = ["--image-size", "256", "220", "--center", "128", "110"]
    assert main([str(table), *size, "--kind", kind, "--out", str(out), "--quiet"]) == 0
    floor = load_floor_camera(out / "camera.yaml")
    assert isinstance(floor.camera, made) and floor.center_px == (128.0, 110.0)
    R = paper_camera().floor_radius(DISTANCES)
    assert np.allclose(floor.floor_distance(R[:-1]), DISTANCES[:-1], rtol=1e-3)


def test_drawn_boards_give_their_camera_back(tmp_path: Path) -> None:
    folder, out = board_folder(tmp_path / "boards"), tmp_path / "out"
    assert main([str(folder), "--model", "round", "--out", str(out), "--quiet"]) == 0
    camera = load_camera(out / "camera.yaml")
    assert isinstance(camera, UnifiedCamera)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["rms_px"] < 0.2 and summary["num_views"] == len(BOARD_POSES)
    assert camera.center_px == pytest.approx((322.0, 238.0), abs=1.5)
    assert camera.max_radius_px == pytest.approx(220.0, abs=3.0)
    # Single values trade off; the rays are right where boards were.
    truth = UnifiedCamera(
        width_px=640, height_px=480, xi=1.0, fx_px=150.0, fy_px=150.0, center_u_px=322.0,
        center_v_px=238.0,
    )  # fmt: skip
    pixels = np.array([[322.0 + 100.0, 238.0], [322.0, 238.0 - 90.0], [250.0, 180.0]])
    cosines = (truth.rays(pixels) * camera.rays(pixels)).sum(axis=1)
    assert (np.degrees(np.arccos(np.minimum(cosines, 1.0))) < 1.0).all()


def test_known_points_give_the_mount(tmp_path: Path) -> None:
    pairs_file(tmp_path / "pairs.csv")
    first, out = tmp_path / "first", tmp_path / "out"
    size = ["--image-size", "256", "220"]
    assert main([str(tmp_path / "pairs.csv"), *size, "--out", str(first), "--quiet"]) == 0
    camera = load_camera(first / "camera.yaml")
    truth = FloorCamera(camera, 0.25, 0.01, -0.02, 0.4)
    points = np.random.default_rng(0).uniform(-0.8, 0.8, (12, 2))
    pixels = truth.floor_pixels(points)
    rows = [f"{u} {v} {x} {y}" for (u, v), (x, y) in zip(pixels, points, strict=True)]
    (tmp_path / "points.txt").write_text("u_px v_px x_m y_m\n" + "\n".join(rows))
    options = ["--camera", str(first / "camera.yaml"), "--free", "height,yaw,tilt"]
    assert main([str(tmp_path / "points.txt"), *options, "--out", str(out), "--quiet"]) == 0
    found = load_floor_camera(out / "camera.yaml")
    assert found.height_m == pytest.approx(0.25, abs=1e-4)
    assert found.pitch_rad == pytest.approx(-0.02, abs=1e-4)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("1,2\n3,4\n", "must name the columns"),
        ("radius_px,distance\n3,4\n", "_m, _cm or _mm"),
        ("radius_px,distance_m\n", "no measurement"),
        ("radius_px,distance_m\n1,2,3\n", ":2: expected 2 values, got 3"),
        ("radius_px,distance_m\n1,two\n", ":2: could not convert"),
        ("radius_px,distance_m\n1,2\n2,3\n", "at least 4 different"),
    ],
)
def test_a_bad_table_is_one_line(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "table.csv").write_text(text)
    with pytest.raises(UserError, match=said) as caught:
        main([str(tmp_path / "table.csv"), "--image-size", "9", "9", "--out", str(tmp_path / "o")])
    assert "\n" not in str(caught.value) and not (tmp_path / "o").exists()


def test_bad_pictures_and_missing_sizes_are_said(tmp_path: Path) -> None:
    table = pairs_file(tmp_path / "pairs.csv")
    (tmp_path / "no.png").write_bytes(b"no picture")
    cv2.imwrite(str(tmp_path / "blank.png"), np.full((60, 80), 128, np.uint8))
    for arguments, said in (
        ([table], "--image-size"),
        ([tmp_path / "no.png"], "not a picture"),
        ([tmp_path / "blank.png"], "found in 0 of 1"),
        ([table, tmp_path / "blank.png"], "one table, or pictures"),
        ([tmp_path / "none.csv"], "none.csv"),
    ):
        with pytest.raises(UserError, match=said):
            main([*map(str, arguments), "--quiet", "--out", str(tmp_path / "o")])


def test_units_and_separators_of_a_table(tmp_path: Path) -> None:
    path = tmp_path / "t.txt"
    for text in ("radius_px;distance_cm\n50;30\n", "distance_mm\tradius_px\n300\t50 # x\n"):
        path.write_text(text)
        table = read_table(path)
        assert table.pixels.tolist() == [50.0] and table.metres == pytest.approx([0.3])


def test_no_board_is_none_and_no_disk_is_none() -> None:
    blank = np.full((200, 300), 128, np.uint8)
    assert find_corners(blank, (6, 8)) is None and find_edge(blank) is None
    cv2.rectangle(blank, (50, 50), (250, 150), 255, -1)
    assert find_edge(blank) is None


def test_corners_are_found_where_they_were_drawn() -> None:
    found = find_corners(board_picture(BOARD_POSES[0]), (6, 8))
    expected = view_pixels(INTRINSICS, np.array(BOARD_POSES[0]), board_points((6, 8)))
    assert found is not None
    nearest = np.linalg.norm(found[:, None] - expected[None], axis=2).min(axis=1)
    assert np.sqrt((nearest**2).mean()) < 0.25


@pytest.mark.skipif(not REAL.is_dir(), reason="the recordings are not here")
def test_real_parabolic_mirror_is_fitted_to_half_a_pixel(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main([str(REAL), "--out", str(out), "--quiet"]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["num_views"] == 5 and summary["rms_px"] <= 0.5
    assert max(summary["view_rms_px"].values()) <= 0.5
    edge = find_edge(read_gray(sorted(REAL.iterdir())[0]))
    camera = load_camera(out / "camera.yaml")
    assert edge is not None and camera.center_px == pytest.approx(edge[:2], abs=5.0)
