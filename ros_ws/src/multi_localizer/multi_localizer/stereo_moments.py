"""Moments of stereo views with odometry, followed by a localizer made for the cameras that show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoPose
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera

_SAME = 1e-3  # m, rad, and of pixels the focal length


class StereoMoments:
    """Finds and follows the pose from moment to moment.

    What a localizer keeps of the map depends on where the cameras are, and takes seconds to make:
    the first pair waits a while for the others; one that appears later, or is mounted anew, makes
    it begin again.

    Args:
        voxels: The map.
        config: Method and tuning.
        pairs: Names of the pairs.
        wait_ns: How long the first pair waits for the others.
        num_threads: Threads of the search.
    """

    def __init__(
        self,
        voxels: VoxelMap,
        config: StereoLocalizerConfig,
        pairs: Sequence[str],
        wait_ns: int,
        num_threads: int = 1,
    ) -> None:
        self._voxels, self._config = voxels, config
        self._pairs, self._wait_ns, self._num_threads = tuple(pairs), wait_ns, num_threads
        self._cameras: dict[str, ViewCamera] = {}
        self._localizer: StereoLocalizer | None = None
        self.reset()

    def reset(self) -> None:
        """Forget where the robot is, and when."""
        self._last: tuple[int, SE2 | None] | None = None
        self._since_ns: int | None = None
        if self._localizer is not None:
            self._localizer.reset()

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other tuning; the pose is found anew."""
        self._config, self._localizer = config, None
        self.reset()

    def warm_up(self) -> None:
        """Compile what locating needs, on a small map."""
        occupied = np.zeros((4, 40, 40), dtype=bool)
        occupied[0] = True
        occupied[:, 0] = occupied[:, -1] = occupied[:, :, 0] = occupied[:, :, -1] = True
        color = np.where(occupied[..., None], np.uint8(120), np.uint8(0)).repeat(3, axis=3)
        room = VoxelMap(color, occupied, 0.1, 0.6)
        camera = ViewCamera(320, 240, 280.0, 0.1, 1.0)
        StereoLocalizer(room, [camera], self._config, self._num_threads).warm_up()

    def locate(
        self,
        stamp_ns: int,
        cameras: Mapping[str, ViewCamera],
        views: Mapping[str, StereoView],
        T_odom_base: SE2 | None,
    ) -> StereoPose | None:
        """Return the pose at a moment; None while other pairs are waited for.

        Args:
            stamp_ns: Of the moment; one that is not later than the last begins anew.
            cameras: Of the pairs that show something, by name.
            views: What they show.
            T_odom_base: Odometry then; None to take the robot to stand.
        """
        if not self._is_prepared(stamp_ns, cameras):
            return None
        assert self._localizer is not None
        motion, dt = self._since_last(stamp_ns, T_odom_base)
        self._last = stamp_ns, T_odom_base
        return self._localizer.track([views.get(n) for n in self._cameras], motion, dt)

    def _is_prepared(self, stamp_ns: int, cameras: Mapping[str, ViewCamera]) -> bool:
        is_new = any(not _are_same(self._cameras.get(n), c) for n, c in cameras.items())
        if self._localizer is not None and not is_new:
            return True
        self._cameras.update(cameras)
        if self._since_ns is None or stamp_ns < self._since_ns:
            self._since_ns = stamp_ns
        is_waiting = len(self._cameras) < len(self._pairs) and self._localizer is None
        if is_waiting and stamp_ns - self._since_ns < self._wait_ns:
            return False
        known = {name: self._cameras[name] for name in self._pairs if name in self._cameras}
        self._cameras, self._last = known, None
        self._localizer = StereoLocalizer(
            self._voxels, list(known.values()), self._config, self._num_threads
        )
        return True

    def _since_last(self, stamp_ns: int, T_odom_base: SE2 | None) -> tuple[SE2, float]:
        if self._last is None:
            return SE2.identity(), 0.0
        last_ns, T_odom_last = self._last
        if stamp_ns <= last_ns:
            assert self._localizer is not None
            self._localizer.reset()
            return SE2.identity(), 0.0
        dt = 1e-9 * (stamp_ns - last_ns)
        if T_odom_base is None or T_odom_last is None:
            return SE2.identity(), dt
        return T_odom_last.inverse() @ T_odom_base, dt


def _are_same(one: ViewCamera | None, other: ViewCamera) -> bool:
    if one is None or (one.width_px, one.height_px) != (other.width_px, other.height_px):
        return False
    first, second = (
        np.array((c.focal_px / c.width_px, c.baseline_m, c.height_m, c.x_m, c.y_m, np.cos(c.yaw),
         np.sin(c.yaw), c.center_px[0] / c.width_px, c.center_px[1] / c.width_px))
        for c in (one, other)
    )  # fmt: skip
    return bool(np.abs(first - second).max() <= _SAME)
