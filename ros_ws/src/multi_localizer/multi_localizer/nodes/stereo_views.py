"""What all stereo pairs show at one moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.watchdog import Watchdog
from floornav_common.se2 import SE2
from multi_localizer.nodes.stereo_view_input import DISPARITY, LEFT, StereoViewInput
from multi_localizer.stereo_localizer_node_config import StereoLocalizerNodeConfig
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_view import ViewCamera


@dataclass(frozen=True)
class Seen:
    """What was seen at one stamp.

    Attributes:
        cameras: By pair.
        views: By pair.
        T_odom_base: Odometry; None without.
    """

    cameras: dict[str, ViewCamera]
    views: dict[str, StereoView]
    T_odom_base: SE2 | None


class StereoViews:
    """Subscribes to all pairs, and puts together what came with one stamp.

    Args:
        node: The node.
        config: The node's.
        add: Called with each part of a pair, see `StereoViewInput`.
    """

    def __init__(
        self,
        node: FloornavNode,
        config: StereoLocalizerNodeConfig,
        add: Callable[[str, int, Any], None],
    ) -> None:
        """Subscribe at once."""
        self._has_odom = config.use_odom
        target = node.frames.odom if config.use_odom else node.frames.base
        self._inputs = {
            name: StereoViewInput(node, name, config, target, add) for name in config.pairs
        }

    @property
    def watchdogs(self) -> dict[str, Watchdog]:
        """Of each pair's disparities."""
        return {name: one.watchdog for name, one in self._inputs.items()}

    def seen(self, group: dict[str, Any], farthest_m: float) -> Seen | None:
        """Return what a group of parts shows; None if no pair is whole.

        Raises:
            ValueError: If a part is not usable.
            TransformUnavailable: TF does not say where a camera is.
        """
        cameras: dict[str, ViewCamera] = {}
        views: dict[str, StereoView] = {}
        T_odom_base = None
        for name, one in self._inputs.items():
            disparity, left = (group.get(f"{name}/{part}") for part in (DISPARITY, LEFT))
            if disparity is None or left is None:
                continue
            msg, T_target_camera = disparity
            cameras[name], T_base_camera = one.camera(msg)
            views[name] = one.view(msg, left, cameras[name], farthest_m)
            if self._has_odom:
                T_odom_base = (T_target_camera @ T_base_camera.inverse()).to_se2()
        return Seen(cameras, views, T_odom_base) if views else None
