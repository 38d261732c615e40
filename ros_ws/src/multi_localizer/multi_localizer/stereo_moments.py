"""Moments of stereo views with odometry, followed by a localizer made for the cameras that show."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoPose, StereoState
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera, VoxelScene

_JUMP_M, _JUMP_RAD = 0.5, 0.5
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

    Attributes:
        doing: What takes seconds just now; "" for nothing. May be read from another thread.
    """

    def __init__(
        self,
        voxels: VoxelMap,
        config: StereoLocalizerConfig,
        pairs: Sequence[str],
        wait_ns: int,
        num_threads: int = 1,
    ) -> None:
        self.doing = ""
        self._scene, self._config = VoxelScene(voxels, num_threads), config
        self._pairs, self._wait_ns, self._num_threads = tuple(pairs), wait_ns, num_threads
        self._cameras: dict[str, ViewCamera] = {}
        self._localizer: StereoLocalizer | None = None
        self.reset()

    def reset(self) -> None:
        """Forget where the robot is, and when."""
        self._last: tuple[int, SE2 | None] | None = None
        self._since_ns: int | None = None
        self._told: PoseEstimate | None = None
        self._expected: SE2 | None = None
        self._news = ""
        if self._localizer is not None:
            self._localizer.reset()

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other tuning; the pose stays."""
        self._config = config
        if self._localizer is not None:
            self._localizer.reconfigure(config)

    def relocate(self, told: PoseEstimate) -> None:
        """Believe somebody who says where the robot is: look for it there with the next views."""
        self._told = told

    def take_news(self) -> str:
        """Return once where the robot was found again; "" if nothing is to be said."""
        news, self._news = self._news, ""
        return news

    def take_refusal(self) -> str:
        """Return once why a told pose was not believed; "" if nothing is to be said."""
        return "" if self._localizer is None else self._localizer.take_refusal()

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
            T_odom_base: Odometry then; None without: the robot may go anywhere.
        """
        if not self._is_prepared(stamp_ns, cameras):
            return None
        assert self._localizer is not None
        motion, dt = self._since_last(stamp_ns, T_odom_base)
        self._last = stamp_ns, T_odom_base
        if self._told is not None:
            self._localizer.relocate(self._told)
            self._told = self._expected = None
        self.doing = "the pose is looked for"
        found = self._localizer.track([views.get(n) for n in self._cameras], motion, dt)
        self.doing = ""
        self._compare(found, motion)
        return found

    def _compare(self, found: StereoPose, motion: SE2 | None) -> None:
        """Note whether a pose follows from the last one that was known."""
        expected = self._expected
        if expected is not None and motion is not None:
            expected = expected @ motion
        if found.state is StereoState.KNOWN and found.pose is not None:
            if expected is not None:
                x, y, yaw = np.abs(difference(found.pose, expected)).tolist()
                if max(math.hypot(x, y) / _JUMP_M, yaw / _JUMP_RAD) > 1.0:
                    self._news = (
                        f"found again {math.hypot(x, y):.2f} m and {math.degrees(yaw):.0f} degrees "
                        "from where the motion has it"
                    )
            expected = found.pose
        self._expected = expected

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
        self.doing = "the map's views are drawn for these cameras, which takes some seconds"
        self._localizer = StereoLocalizer(
            self._scene, list(known.values()), self._config, self._num_threads
        )
        return True

    def _since_last(self, stamp_ns: int, T_odom_base: SE2 | None) -> tuple[SE2 | None, float]:
        if self._last is None:
            return SE2.identity(), 0.0
        last_ns, T_odom_last = self._last
        if stamp_ns <= last_ns:
            assert self._localizer is not None
            self._localizer.reset()
            self._expected = None
            return SE2.identity(), 0.0
        dt = 1e-9 * (stamp_ns - last_ns)
        if T_odom_base is None or T_odom_last is None:
            return None, dt
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
