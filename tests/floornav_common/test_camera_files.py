"""One file for all kinds: what is written comes back; what is wrong is said."""

from pathlib import Path

import pytest
from camera_builders import CAMERAS

from floornav_common.camera_files import (
    load_camera,
    load_floor_camera,
    save_camera,
    save_floor_camera,
)
from floornav_common.cameras.hyperboloidal_mirror import paper_camera
from floornav_common.floor_camera import FloorCamera

MIRROR_TEXT = """\
kind: hyperboloidal_mirror
width_px: 256
height_px: 220
a_px_per_mm: 10.12
b_per_mm: 0.02054
c_px2: 229800
center_u_px: 127.5
center_v_px: 109.5
max_radius_px: 110
"""


@pytest.mark.parametrize("name", CAMERAS)
def test_the_file_brings_the_camera_and_its_mount_back(tmp_path: Path, name: str) -> None:
    path = tmp_path / "camera.yaml"
    floor = FloorCamera(CAMERAS[name], 0.7, 0.01, -0.02, 1.5, (0.1, -0.2))
    save_floor_camera(floor, path, "made by\na test")
    assert path.read_text().startswith("# made by\n# a test\nkind: ")
    assert load_floor_camera(path) == floor
    assert load_camera(path) == floor.camera


def test_a_mirrors_own_height_does_without_mount(tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    save_camera(paper_camera(), path)
    assert load_floor_camera(path) == FloorCamera(paper_camera(), paper_camera().viewpoint_height)
    path.write_text(MIRROR_TEXT)  # integers do for numbers
    assert load_camera(path) == paper_camera()
    path.write_text(MIRROR_TEXT + "mount: {height_m: 0.3, roll_rad: 0.02}\n")
    assert load_floor_camera(path) == FloorCamera(paper_camera(), 0.3, 0.02)


def test_other_kinds_need_a_height(tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    save_camera(CAMERAS["unified"], path)
    assert load_camera(path) == CAMERAS["unified"]
    with pytest.raises(ValueError, match="height_m is missing"):
        load_floor_camera(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1]", "kind"),
        ("kind: pinhole", "kind: hyperboloidal_mirror or unified or"),
        ("kind: [1]", "kind"),
        ("kind: hyperboloidal_mirror\nwidth_px: 3", "missing: height_px"),
        ("kind: [", "YAML"),
        (MIRROR_TEXT + "rotatoin_rad: 1.0\n", "did you mean 'rotation_rad'"),
        (MIRROR_TEXT + "mount: 3\n", "mount must be a mapping"),
        (MIRROR_TEXT + "mount: {hight_m: 1.0}\n", "did you mean 'height_m'"),
        (MIRROR_TEXT + "mount: {height_m: -1.0}\n", "height_m must be >= 0"),
        (MIRROR_TEXT + "mount: {position_m: [1.0]}\n", "position_m must have 2"),
        (MIRROR_TEXT.replace("10.12", ".nan"), "a_px_per_mm must be finite"),
        (MIRROR_TEXT.replace("10.12", "wide"), "a_px_per_mm must be a number"),
        (MIRROR_TEXT.replace("10.12", "9.0"), "viewpoint"),
    ],
)
def test_a_bad_file_is_refused_with_its_name(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=said) as caught:
        load_floor_camera(path)
    assert "camera.yaml" in str(caught.value)


def test_a_file_that_is_not_there_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="none.yaml"):
        load_floor_camera(tmp_path / "none.yaml")
