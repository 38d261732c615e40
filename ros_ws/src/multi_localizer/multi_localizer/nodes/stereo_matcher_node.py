"""Disparities of stereo pairs.

In, for each of `pairs`: `stereo/<pair>/<left, right>/image_rect` (Image, or .../compressed) and
`stereo/<pair>/<left, right>/camera_info` (CameraInfo). The two images have one stamp.
Out: `stereo/<pair>/disparity` (DisparityImage in the left camera's frame; -1 where there is none;
nothing for images that are no rectified pair).
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import numpy as np
from stereo_msgs.msg import DisparityImage

from floornav_common.ros.main import run_node
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from multi_localizer.nodes.stereo_pair_input import StereoPairInput
from multi_localizer.ros_conversions import disparities_to_msg
from multi_localizer.stereo_cameras import RectifiedPair
from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_matcher import StereoMatcher
from multi_localizer.stereo_pairs_config import StereoPairsConfig


class StereoMatcherNode(FloornavNode):
    """Feeds pairs to a StereoMatcher and publishes what it finds."""

    def __init__(self) -> None:
        """Declare, subscribe, compile, and say ready."""
        super().__init__("stereo_matcher")
        config = declare_config(self, StereoPairsConfig)
        matching = declare_config(self, StereoMatcherConfig, on_change=self._tune)
        self._num_threads = int(self.get_parameter("num_threads").value)
        self._matcher = StereoMatcher(matching, self._num_threads)
        self._outputs = {
            name: create_publisher(self, DisparityImage, f"stereo/{name}/disparity", RELIABLE_QOS)
            for name in config.pairs
        }
        self._inputs = [
            StereoPairInput(self, name, config, partial(self._on_pair, name))
            for name in config.pairs
        ]
        self.ready(self._matcher.warm_up)

    def _tune(self, config: StereoMatcherConfig) -> None:
        self._matcher = StereoMatcher(config, self._num_threads)

    def _on_pair(
        self, name: str, header: Any, left: np.ndarray, right: np.ndarray, cameras: RectifiedPair
    ) -> None:
        found = self._matcher.match(left, right)
        num = self._matcher.config.num_disparities
        self._outputs[name].publish(disparities_to_msg(found, cameras, num, header))


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(StereoMatcherNode, args)


if __name__ == "__main__":
    sys.exit(main())
