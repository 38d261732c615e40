"""The maps that the mapping node publishes, all latched: the whole, and each layer.

Making them takes tens of milliseconds and more, the larger the floor; a thread of its own does it,
so that scans and readings need not wait.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Lock
from typing import Any

from nav_msgs.msg import OccupancyGrid

from floornav_common.grid import OccupancyMap
from floornav_common.ros import messages
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import LATCHED_QOS, create_publisher, create_subscription
from grid_mapper.layers_moment import LayersMoment
from grid_mapper.map_resampling import obstacles_on
from grid_mapper.ros_conversions import empty_map


class MapOutputs:
    """Publishes `map`, `map/laser`, `map/sonar` and `map/glass`.

    A layer that has no cells is not published. With a reference map `map/glass` waits for it and
    is on its cells from then on, also before there is any glass.

    Args:
        node: The node.
        has_map: False where `map` is somebody else's, and only layers are published.
        reference: Topic of the reference map; "" for none.
        warn: Called with what to say, throttled.

    Attributes:
        has_news: True when maps have to be published anew though nothing was mapped.
        laser_map: What the laser alone says, as last published; None before.
    """

    def __init__(
        self, node: FloornavNode, has_map: bool, reference: str, warn: Callable[[str], None]
    ) -> None:
        """Make the publishers, and listen for the reference map."""
        self._node, self._warn = node, warn
        self.has_news = False
        self.laser_map: OccupancyMap | None = None
        self._thread = ThreadPoolExecutor(1, "maps")
        self._making: Future[None] | None = None
        self._lock, self._generation = Lock(), 0
        self._reference: OccupancyMap | None = None
        self._waits_for_reference = bool(reference)
        names = ("map",) * has_map + ("map/laser", "map/sonar", "map/glass")
        self._publishers = {
            name: create_publisher(node, OccupancyGrid, name, LATCHED_QOS) for name in names
        }
        if reference:
            create_subscription(node, OccupancyGrid, reference, self._on_reference, LATCHED_QOS)

    def is_busy(self) -> bool:
        """Tell whether maps are being made; raises what went wrong with those made last."""
        if self._making is None or not self._making.done():
            return self._making is not None
        self._making.result()
        self._making = None
        return False

    def publish(self, moment: LayersMoment, stamp: Any) -> None:
        """Begin to make and publish all maps of a moment that have cells."""
        self.has_news = False
        self._making = self._thread.submit(self._make, moment, stamp, self._generation)

    def publish_nothing_known(self, resolution: float, stamp: Any) -> None:
        """Replace the latched maps, so that the old ones do not stay up."""
        nothing = empty_map(resolution)
        with self._lock:
            self._generation += 1
            self.laser_map = None
        for name in self._publishers:
            on_reference = name == "map/glass" and self._reference is not None
            cells = obstacles_on(nothing, self._reference) if on_reference else nothing
            self._send(name, cells, stamp, self._generation)

    def close(self) -> None:
        """Publish no more, and wait for what is being made."""
        with self._lock:
            self._generation += 1
        self._thread.shutdown(cancel_futures=True)

    def _make(self, moment: LayersMoment, stamp: Any, generation: int) -> None:
        layers, reference = moment.layers(), self._reference
        with self._lock:  # what was begun before a reset is too old
            if generation == self._generation and layers.laser.cells.size:
                self.laser_map = layers.laser
        self._send("map", layers.occupancy, stamp, generation)
        self._send("map/laser", layers.laser, stamp, generation)
        self._send("map/sonar", layers.sonar, stamp, generation)
        if reference is not None:
            self._send("map/glass", obstacles_on(layers.glass, reference), stamp, generation)
        elif not self._waits_for_reference and layers.sonar.cells.size:
            self._send("map/glass", layers.glass, stamp, generation)

    def _send(self, name: str, grid: OccupancyMap, stamp: Any, generation: int) -> None:
        if name not in self._publishers or not grid.cells.size:
            return
        msg = messages.grid_to_msg(grid, stamp, self._node.frames.map)
        with self._lock:
            if generation == self._generation:
                self._publishers[name].publish(msg)

    def _on_reference(self, msg: Any) -> None:
        frame = self._node.frames.map
        if msg.header.frame_id.lstrip("/") != frame:
            self._warn(f"reference map is in '{msg.header.frame_id}', not in '{frame}': ignored")
            return
        try:
            self._reference = messages.grid_from_msg(msg)
            self.has_news = True
        except ValueError as error:
            self._warn(f"reference map ignored: {error}")
