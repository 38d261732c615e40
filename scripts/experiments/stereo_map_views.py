"""Posed views of a simulated room as a folder that `make_voxel_map --views` reads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from experiments.stereo_views import StereoRoom
from floornav_common.se2 import SE2
from multi_localizer.make_voxel_map import main as make_voxel_map
from sim_bridge.still_shapes import upright_pose

DEPTH_PER_M, NUM_PLACES = 5000.0, 60
_SEED_OFF = 1000  # the map is made from other places than those it is judged at


def map_of_views(folder: Path, out: Path, room: StereoRoom, is_stereo: bool, seed: int) -> None:
    """Write what the robot sees at random places to a folder, and the map that the tool makes."""
    rng = np.random.default_rng(seed + _SEED_OFF)
    write_views(folder, room, [room.standing_pose(rng) for _ in range(NUM_PLACES)], is_stereo)
    floor, top = room.world.floor, room.world.ceiling_m or 2.5
    bounds = [*floor.from_m, 0.0, *floor.to_m, top]
    args = ["--views", str(folder), "--out", str(out), "--quiet", "--bounds"]
    make_voxel_map([*args, *(f"{b:g}" for b in bounds)])


def write_views(folder: Path, room: StereoRoom, poses: Sequence[SE2], is_stereo: bool) -> None:
    """Write what all pairs see from poses: stereo pairs, or color images with true distances."""
    kinds = ("left", "right") if is_stereo else ("color", "depth")
    for kind in kinds:
        (folder / kind).mkdir(parents=True)
    rows = []
    for k, pose in enumerate(poses):
        for j, (pair, T_base_left) in enumerate(room.T_base_left.items()):
            view, stamp = room.view(pose, k, pair), k + 0.1 * j
            depth = np.clip(np.rint(DEPTH_PER_M * view.depth), 0, 65535).astype(np.uint16)
            second = view.right[..., ::-1] if is_stereo else depth
            for kind, image in zip(kinds, (view.left[..., ::-1], second), strict=True):
                cv2.imwrite(str(folder / kind / f"{stamp:.1f}.png"), image)
            T = upright_pose(pose, 0.0) @ T_base_left
            rows.append((stamp, *T[:3, 3], *Rotation.from_matrix(T[:3, :3]).as_quat()))
    np.savetxt(folder / "poses.txt", rows, fmt="%.9g", header="stamp x y z qx qy qz qw")
    center = [(n - 1) / 2.0 for n in room.size_px]
    camera = {"fx": room.focal_px, "fy": room.focal_px, "cx": center[0], "cy": center[1]}
    more = {"baseline_m": room.baseline_m} if is_stereo else {"depth_per_m": DEPTH_PER_M}
    (folder / "camera.yaml").write_text(yaml.safe_dump({**camera, **more}), encoding="utf-8")
