"""What a camera would see at a pose in a voxel map: color and distance (stereo paper, section 3).

Views are as wide as the camera's image and 8 pixels high, 320 x 8 in the paper, or coarser: each
pixel of a view stands for a block of the image, and takes one ray or several spread evenly over it.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_rays import cast_views, leaps_of

MAX_SLOPE = 10.0


@dataclass(frozen=True)
class ViewCamera:
    """The left camera of a rectified pair on a robot; it looks level.

    Attributes:
        width_px: Columns of its image.
        height_px: Rows.
        focal_px: Focal length.
        baseline_m: From it to the right camera.
        height_m: Above the floor, z in the map's frame.
        x_m: In base_link.
        y_m: In base_link.
        yaw: Where it looks, in base_link.
        center_u_px: Principal point; None for the middle of the image.
        center_v_px: See center_u_px.
        disparity_offset_px: Disparity of what is infinitely far.
    """

    width_px: int
    height_px: int
    focal_px: float
    baseline_m: float
    height_m: float
    x_m: float = 0.0
    y_m: float = 0.0
    yaw: float = 0.0
    center_u_px: float | None = None
    center_v_px: float | None = None
    disparity_offset_px: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and not np.isfinite(value):
                raise ValueError(f"{name} must be finite, got {value}")
        for name in ("width_px", "height_px", "focal_px", "baseline_m"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be above 0, got {getattr(self, name)}")
        slopes = self.width_px / self.focal_px, self.height_px / self.focal_px
        if max(slopes) > MAX_SLOPE:
            raise ValueError(f"focal_px is too short for the image, got {self.focal_px}")

    @property
    def center_px(self) -> tuple[float, float]:
        """Principal point (u, v)."""
        u = (self.width_px - 1) / 2.0 if self.center_u_px is None else self.center_u_px
        v = (self.height_px - 1) / 2.0 if self.center_v_px is None else self.center_v_px
        return u, v

    @property
    def pixel_meters(self) -> float:
        """Disparity times distance, px m."""
        return self.focal_px * self.baseline_m

    def rays(self, columns: int, rows: int) -> np.ndarray:
        """Return slopes (to the left, up) of rays through the middles of blocks of the image.

        Args:
            columns: How many blocks a row has.
            rows: How many rows of blocks.

        Returns:
            (rows, columns, 2).
        """
        u = (np.arange(columns) + 0.5) * self.width_px / columns - 0.5
        v = (np.arange(rows) + 0.5) * self.height_px / rows - 0.5
        left = (self.center_px[0] - u) / self.focal_px
        up = (self.center_px[1] - v) / self.focal_px
        return np.stack(np.meshgrid(left, up), axis=-1)


class VoxelScene:
    """A voxel map made ready for rays.

    Args:
        voxels: The map.
        num_threads: Threads that share the poses; the views do not depend on it.

    Attributes:
        voxels: The map.
        leaps: How far the next occupied voxel is, see `voxel_rays`.
        rgb: The voxels' colors, (layers, rows, columns, 3), uint8.
    """

    def __init__(self, voxels: VoxelMap, num_threads: int = 1) -> None:
        self.voxels = voxels
        self.leaps = leaps_of(voxels.occupied)
        self.rgb = np.array(voxels.color, order="C")
        self._pool = ThreadPoolExecutor(num_threads) if num_threads > 1 else None
        self._num_threads = num_threads

    @cached_property
    def scale(self) -> tuple[float, float]:
        """Cells and layers per meter."""
        return 1.0 / self.voxels.cell_m, 1.0 / self.voxels.layer_m

    def eyes(self, poses: np.ndarray, camera: ViewCamera) -> np.ndarray:
        """Return where a camera is, in cells and layers, and how it is turned.

        Args:
            poses: Of base_link in the map's frame, (N, 3): x, y, yaw.
            camera: The camera.

        Returns:
            (N, 5): x, y, z, cosine, sine of its yaw.
        """
        m = self.voxels
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x = poses[:, 0] + c * camera.x_m - s * camera.y_m - m.origin_x_m
        y = poses[:, 1] + s * camera.x_m + c * camera.y_m - m.origin_y_m
        z = np.full(len(poses), (camera.height_m - m.origin_z_m) * self.scale[1])
        yaw = poses[:, 2] + camera.yaw
        return np.stack((x * self.scale[0], y * self.scale[0], z, np.cos(yaw), np.sin(yaw)), axis=1)

    def is_free(self, poses: np.ndarray, camera: ViewCamera) -> np.ndarray:
        """Return whether a camera at each pose is inside the map and in no occupied voxel, (N,)."""
        column, row, layer = np.floor(self.eyes(poses, camera)[:, :3]).astype(np.int64).T
        layers, rows, columns = self.voxels.shape
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        inside &= (layer >= 0) & (layer < layers)
        inside[inside] = self.leaps[layer[inside], row[inside], column[inside]] > 0
        return inside

    def render(
        self,
        poses: np.ndarray,
        camera: ViewCamera,
        size: tuple[int, int],
        per_pixel: tuple[int, int] = (1, 1),
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return what a camera sees from many poses.

        Args:
            poses: Of base_link in the map's frame, (N, 3): x, y, yaw.
            camera: The camera.
            size: Columns and rows (w, h) of the views.
            per_pixel: Columns and rows of rays that each pixel takes the mean of.

        Returns:
            Mean RGB, 0..255, (N, h, w, 3), and mean distance along the camera's axis, (N, h, w), m,
            NaN where no ray meets anything; both float32.
        """
        poses = np.asarray(poses, dtype=float).reshape(-1, 3)
        color = np.empty((len(poses), size[1], size[0], 3), dtype=np.float32)
        distance = np.empty(color.shape[:3], dtype=np.float32)
        rays = camera.rays(size[0] * per_pixel[0], size[1] * per_pixel[1])
        fixed = (
            self.leaps, self.rgb, self.scale, self.eyes(poses, camera), rays,
            (per_pixel[1], per_pixel[0]), color, distance,
        )  # fmt: skip
        self.share(len(poses), cast_views, *fixed)
        return color, distance

    def share(self, num: int, do, *args: object) -> None:  # type: ignore[no-untyped-def]
        """Call do(start, stop, *args) for parts of `num` things that together are all of them."""
        if self._pool is None or num < self._num_threads:
            do(0, num, *args)
            return
        edges = np.linspace(0, num, 4 * self._num_threads + 1).astype(int).tolist()
        parts = zip(edges[:-1], edges[1:], strict=True)
        for done in [self._pool.submit(do, start, stop, *args) for start, stop in parts]:
            done.result()


def render_views(
    voxels: VoxelMap,
    poses: np.ndarray,
    camera: ViewCamera,
    size: tuple[int, int],
    per_pixel: tuple[int, int] = (1, 1),
) -> tuple[np.ndarray, np.ndarray]:
    """Return `VoxelScene(voxels).render(...)`, for who needs views of a map only once."""
    return VoxelScene(voxels).render(poses, camera, size, per_pixel)
