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
