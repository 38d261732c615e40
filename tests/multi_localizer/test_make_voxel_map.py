"""The command that makes voxel maps, from folders of posed views."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from floornav_common.reporting import UserError
from multi_localizer.make_voxel_map import main
from multi_localizer.voxel_map import VoxelMap, load_voxel_map
from multi_localizer.voxel_view_files import load_posed_views

CAMERA = {"fx": 100.0, "fy": 100.0, "cx": 63.5, "cy": 31.5}
WALL_M, BASELINE_M = 1.25, 0.1
POSE = "0 0 0.5 -0.5 0.5 -0.5 0.5"  # looks along +x
BOUNDS = ["--bounds", "0", "-0.3", "0.2", "1.5", "0.3", "0.8"]


def folder_of(path: Path, is_stereo: bool, poses: str = f"1.0 {POSE}\n") -> Path:
    """Write one view of a wall of noise, WALL_M before the camera."""
    noise = np.random.default_rng(0).integers(0, 256, (64, 160, 3), dtype=np.uint8)
    if is_stereo:
        shift = round(CAMERA["fx"] * BASELINE_M / WALL_M)
        images = {"left": noise[:, :128], "right": noise[:, shift : 128 + shift]}
    else:
        depth = np.full((64, 128), round(1000 * WALL_M), np.uint16)
        images = {"color": noise[:, :128], "depth": depth}
    for kind, image in images.items():
        (path / kind).mkdir(parents=True)
        cv2.imwrite(str(path / kind / "1.0.png"), image)
    more = {"baseline_m": BASELINE_M} if is_stereo else {"depth_per_m": 1000}
    (path / "camera.yaml").write_text(yaml.safe_dump({**CAMERA, **more}))
    (path / "poses.txt").write_text(poses)
    return path


@pytest.mark.parametrize("is_stereo", [False, True])
def test_a_wall_is_in_the_map_where_it_is_seen(tmp_path, is_stereo):
    views, out = folder_of(tmp_path / "views", is_stereo), tmp_path / "map.npz"
    assert main(["--views", str(views), "--out", str(out), "--quiet", *BOUNDS]) == 0
    voxels = load_voxel_map(out)
    middle = voxels.occupied[int((0.5 - voxels.origin_z_m) / voxels.layer_m)]
    x = voxels.origin_x_m + voxels.cell_m * np.flatnonzero(middle[len(middle) // 2])
    assert x[0] == pytest.approx(WALL_M, abs=0.05 if is_stereo else 0.011)
    assert voxels.cell_m == 0.01 and voxels.layer_m == 0.16 and voxels.frame == "map"


def test_an_image_without_a_pose_is_left_out(tmp_path):
    views = folder_of(tmp_path / "views", is_stereo=False)
    for kind in ("color", "depth"):
        image = cv2.imread(str(views / kind / "1.0.png"), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(views / kind / "2.0.png"), image)
    posed = load_posed_views(views)
    assert (len(posed.views), posed.num_without_pose, posed.is_stereo) == (1, 1, False)
    assert posed.views[0].T_map_camera[:3, 2] == pytest.approx((1.0, 0.0, 0.0))


def test_bad_input_is_named(tmp_path):
    def refused(folder: Path, match: str) -> None:
        with pytest.raises(UserError, match=match):
            main(["--views", str(folder), "--out", str(tmp_path / "m.npz"), "--quiet"])
        assert not (tmp_path / "m.npz").exists()

    refused(tmp_path / "none", "camera.yaml")
    refused(folder_of(tmp_path / "late", False, f"9.0 {POSE}\n"), "has a pose")
    refused(folder_of(tmp_path / "short", False, "1.0 0 0 0\n"), "qx qy qz qw")
    damaged = folder_of(tmp_path / "damaged", is_stereo=False)
    (damaged / "depth" / "1.0.png").write_bytes(b"")
    refused(damaged, "no image")
    (damaged / "camera.yaml").write_text("fx: 1.0\n")
    refused(damaged, "lacks fy")
    existing = tmp_path / "there.npz"
    existing.write_bytes(b"x")
    with pytest.raises(UserError, match="exists"):
        main(["--views", str(damaged), "--out", str(existing)])
    with pytest.raises(UserError, match="simulator"):
        main(["--world", "flat", "--out", str(tmp_path / "m.npz")])


def test_a_world_is_made_by_who_knows_it(tmp_path, capsys):
    occupied = np.ones((2, 3, 4), dtype=bool)
    made = VoxelMap(np.full((2, 3, 4, 3), 7, np.uint8), occupied, 0.5, 0.2)
    asked = []

    def world_maker(name, cell, layer):
        asked.append((name, cell, layer))
        return made

    out = tmp_path / "m.npz"
    args = ["--world", "w", "--out", str(out), "--cell", "0.5", "--layer", "0.2", "--frame", "f"]
    assert main(args, world_maker) == 0
    assert asked == [("w", 0.5, 0.2)] and load_voxel_map(out).frame == "f"
    assert "24 voxels are occupied" in capsys.readouterr().out


def test_cameras_in_folders_of_their_own_make_one_map(tmp_path, capsys):
    one = folder_of(tmp_path / "front", is_stereo=False)
    turned = "0 0 0.5 0.5 0.5 -0.5 -0.5"  # looks along -x
    other = folder_of(tmp_path / "rear", is_stereo=False, poses=f"1.0 {turned}\n")
    (other / "camera.yaml").write_text(yaml.safe_dump({**CAMERA, "fx": 90.0, "depth_per_m": 1000}))
    out = tmp_path / "map.npz"
    assert main(["--views", str(one), str(other), "--out", str(out)]) == 0
    assert "2 views\n" in capsys.readouterr().out
    voxels = load_voxel_map(out)
    x = voxels.origin_x_m + voxels.cell_m * np.flatnonzero(voxels.occupied.any(axis=(0, 1)))
    assert x[0] < -WALL_M < x[-1] and x[-1] > WALL_M
    stereo = folder_of(tmp_path / "stereo", is_stereo=True)
    with pytest.raises(UserError, match="of one kind"):
        main(["--views", str(one), str(stereo), "--out", str(tmp_path / "m.npz")])


def test_an_image_without_its_depth_is_left_out_and_counted(tmp_path, capsys):
    views = folder_of(tmp_path / "views", False, f"1.0 {POSE}\n2.0 {POSE}\n")
    image = cv2.imread(str(views / "color" / "1.0.png"))
    cv2.imwrite(str(views / "color" / "2.0.png"), image)
    posed = load_posed_views(views)
    assert (len(posed.views), posed.num_without_pose, posed.num_single) == (1, 0, 1)
    assert main(["--views", str(views), "--out", str(tmp_path / "m.npz"), *BOUNDS]) == 0
    assert "1 views; 1 lack their depth or right image" in capsys.readouterr().out
    (views / "depth" / "1.0.png").unlink()
    with pytest.raises(ValueError, match="its other half in depth/"):
        load_posed_views(views)


def test_poses_of_another_frame_than_the_optical_one_are_warned_of(tmp_path, capsys):
    upright = folder_of(tmp_path / "upright", is_stereo=False)
    main(["--views", str(upright), "--out", str(tmp_path / "a.npz"), *BOUNDS])
    assert "warning" not in capsys.readouterr().out
    wrong = folder_of(tmp_path / "wrong", is_stereo=False, poses="1.0 0 0 0.5 0 0 0 1\n")
    main(["--views", str(wrong), "--out", str(tmp_path / "b.npz")])
    assert "must be those of the optical frame" in "".join(capsys.readouterr())


def test_options_that_do_nothing_and_maps_too_large_are_refused(tmp_path):
    out = ["--out", str(tmp_path / "m.npz"), "--quiet"]
    for more in (BOUNDS, ["--max-depth", "3"]):
        with pytest.raises(UserError, match="are for --views"):
            main(["--world", "w", *out, *more], lambda *_: pytest.fail("made"))

    def too_large(*_):
        raise MemoryError

    with pytest.raises(UserError, match="larger --cell"):
        main(["--world", "w", *out], too_large)
    views = folder_of(tmp_path / "views", is_stereo=False)
    with pytest.raises(UserError, match="voxels are too many"):
        main(["--views", str(views), *out, "--cell", "0.00001", *BOUNDS])
    camera = {**CAMERA, "depth_per_m": 1000, "baseline_m": 0.1}
    (views / "camera.yaml").write_text(yaml.safe_dump(camera))
    with pytest.raises(UserError, match="not both"):
        main(["--views", str(views), *out])
