"""What the mapping node says of the order in which the beams of a scan are taken."""

from __future__ import annotations

from floornav_common.ros.diagnostics import OK, Status
from floornav_common.ros.node import FloornavNode
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.layers import LayeredMapper

NO_TIMES = "all beams of a scan are of one moment by its time_increment"


class SweepReport:
    """Tells it on the diagnostics, and in the log once it is known or the times are not believed.

    Args:
        node: The node.
        mapper: Learns the order.
    """

    def __init__(self, node: FloornavNode, mapper: LayeredMapper | ClosingMapper) -> None:
        """Add it to the diagnostics."""
        self._node, self._mapper, self._said = node, mapper, ""
        node.diagnostics.add("order of the beams", self.status)

    def status(self) -> Status:
        """Return in which order they are taken."""
        mapper = self._mapper
        sweeps = mapper.sweeps if isinstance(mapper, ClosingMapper) else mapper.laser.sweeps
        words = sweeps.words(mapper.config.deskew)
        if (sweeps.objection or sweeps.order) and words != self._said:
            self._said, log = words, self._node.get_logger()
            if sweeps.objection:
                log.warning(f"beams of a scan: {words}")
            else:
                log.info(f"beams of a scan: {words}")
        return Status(OK, words or NO_TIMES, {"scans compared": sweeps.num_trials})
