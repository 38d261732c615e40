"""Bearings of colored cones and goals in the image of an omnidirectional camera.

In: `omni/image_raw` (Image, or `omni/image_raw/compressed`).
Out: `bearings/<class>` (PoseArray in `floor_frame`, for each class of the file `colors`): one pose
a marker seen, its yaw the bearing, largest first; an empty array: nothing seen; no message: no
camera. Classes with `has_ends` also on `bearings/<class>_left` and `_right`, in the same order.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray

from floor_perception.config import CameraNodeConfig, MarkerNodeConfig
from floor_perception.markers import MarkerClass, MarkerDetector, load_marker_classes
from floor_perception.nodes.image_input import ImageInput
from floor_perception.resources import find_file, load_camera_model, load_hidden_mask
from floornav_common.ros.diagnostics import OK, STALE, WARN, Status
from floornav_common.ros.main import run_node
from floornav_common.ros.messages import poses_to_msg
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError, declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.se2 import SE2


class MarkerDetectorNode(FloornavNode):
    """Feeds images to a MarkerDetector and publishes bearings."""

    def __init__(self) -> None:
        """Declare, load camera and colors, subscribe, compile, and say ready."""
        super().__init__("marker_detector")
        config = declare_config(self, CameraNodeConfig)
        markers = declare_config(self, MarkerNodeConfig)
        self._frame = (self.frames.frame_prefix + config.floor_frame).lstrip("/")
        classes = self._load(config, markers)
        ends = [end for name, kind in classes.items() if kind.has_ends for end in _ends(name)]
        self._pubs = {
            name: create_publisher(self, PoseArray, f"bearings/{name}", RELIABLE_QOS)
            for name in (*classes, *ends)
        }
        self._seen: dict[str, int] = dict.fromkeys(classes, 0)
        self._ms = 0.0
        self._compile()
        self._input = ImageInput(
            self, config.image_transport, config.image_timeout_s, self._on_image
        )
        self.diagnostics.add("markers", self._status)
        self.ready()

    def _load(self, config: CameraNodeConfig, markers: MarkerNodeConfig) -> dict[str, MarkerClass]:
        try:
            classes = load_marker_classes(find_file(markers.colors, "colors"))
            camera = load_camera_model(config.camera_model)
            hidden = load_hidden_mask(config.hidden_mask)
            self._detector = MarkerDetector(camera, classes, hidden)
        except (ValueError, OSError) as error:
            raise ParameterError(f"{self.get_fully_qualified_name()}: {error}") from error
        return classes

    def _compile(self) -> None:
        """Look at an image of nothing, one that may be written to and one that may not."""
        black = np.zeros((220, 256, 3), dtype=np.uint8)
        self._detector.detect(black, "rgb")
        black.flags.writeable = False
        self._detector.detect(black, "rgb")

    def _on_image(self, header: Any, pixels: np.ndarray, order: str) -> None:
        started = time.perf_counter()
        found = self._detector.detect(pixels, order)
        self._input.set_doubt(self._detector.size_doubt)
        self._ms = 1e3 * (time.perf_counter() - started)
        for name, markers in found.items():
            self._publish(name, [marker.bearing for marker in markers], header)
            if _ends(name)[0] in self._pubs:
                ends = [marker.ends for marker in markers if marker.ends is not None]
                for side, topic in enumerate(_ends(name)):
                    self._publish(topic, [both[side] for both in ends], header)
            self._seen[name] = len(markers)

    def _publish(self, name: str, bearings: list[float], header: Any) -> None:
        poses = [SE2(0.0, 0.0, bearing) for bearing in bearings]
        self._pubs[name].publish(poses_to_msg(poses, header.stamp, self._frame))

    def _status(self) -> Status:
        values = {f"{name} seen": num for name, num in self._seen.items()}
        values["processing (ms)"] = f"{self._ms:.2f}"
        if not self._input.watchdog.is_fresh:
            return Status(STALE, "no images: no bearings are sent", values)
        if self._input.refusal:
            return self._input.refused("no bearings are sent", values)
        if self._input.doubt:
            return Status(WARN, self._input.doubt, values)
        return Status(OK, "looking", values)


def _ends(name: str) -> tuple[str, str]:
    """Return the names under which the right and the left ends of a class are published."""
    return f"{name}_right", f"{name}_left"


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(MarkerDetectorNode, args)


if __name__ == "__main__":
    sys.exit(main())
