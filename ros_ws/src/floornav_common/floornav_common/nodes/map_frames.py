"""Where frames are on the map, and which have not been known for a while."""

from __future__ import annotations

from floornav_common.ros.node import FloornavNode
from floornav_common.se2 import SE2
from floornav_common.transform_errors import TransformUnavailable

_FORGET_NS = 2_000_000_000  # nobody asks for it any more


class MapFrames:
    """Looks transforms to the map frame up, and remembers why not.

    A transform that comes a moment after its message is no fault: only what has failed for a while
    is one.

    Args:
        node: The node.
    """

    def __init__(self, node: FloornavNode) -> None:
        """Begin without faults."""
        self._node = node
        self._faults: dict[str, tuple[int, int, str]] = {}  # failing since, asked last, why

    def find(self, frame: str, stamp_ns: int | None = None) -> SE2 | None:
        """Return `T_map_frame` at a stamp, or the newest; None, and a fault, if it is not known."""
        target, now_ns = self._node.frames.map, self._node.time.steady_ns()
        if frame.lstrip("/") == target:
            return SE2.identity()
        try:
            found = self._node.transforms.buffer.lookup(target, frame, stamp_ns).to_se2()
        except (TransformUnavailable, ValueError) as error:
            since_ns = self._faults.get(frame, (now_ns, 0, ""))[0]
            self._faults[frame] = since_ns, now_ns, str(error)
            return None
        self._faults.pop(frame, None)
        return found

    def why_not(self, frame: str) -> str:
        """Return why a frame was not found when it was asked for last, "" if it was."""
        return self._faults[frame][2] if frame in self._faults else ""

    def problems(self, after_s: float, but: str) -> list[str]:
        """Return what has not been placed on the map for a while.

        Args:
            after_s: The while, s.
            but: A frame that is spoken of elsewhere.
        """
        now_ns = self._node.time.steady_ns()
        asked = {f: v for f, v in self._faults.items() if now_ns - v[1] < _FORGET_NS}
        self._faults = asked
        return [
            f"what is in '{frame}' cannot be drawn: {why}"
            for frame, (since_ns, _, why) in asked.items()
            if frame != but and now_ns - since_ns > after_s * 1e9
        ]

    def clear(self) -> None:
        """Forget all faults."""
        self._faults.clear()
