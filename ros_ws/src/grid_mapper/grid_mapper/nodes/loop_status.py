"""Whether the mapping node closes loops: which mapper it takes, and what it says of it."""

from __future__ import annotations

from importlib.util import find_spec

from floornav_common.ros.diagnostics import OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from grid_mapper.background import ProcessWorker
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_session import LoopSession

MISSING = "loops are not closed: the package gtsam is not installed (requirements-robot.txt)"


def make_mapper(
    node: FloornavNode, config: GridMapperConfig, has_own_poses: bool
) -> LayeredMapper | ClosingMapper:
    """Return the mapper that a node's values ask for, and add what it says to the diagnostics."""
    if not (config.loop_closing and has_own_poses):
        return LayeredMapper(config)
    if find_spec("gtsam") is None:
        node.get_logger().warning(MISSING)
        node.diagnostics.set("loops", Status(WARN, MISSING))
        return LayeredMapper(config)
    mapper = ClosingMapper(config, ProcessWorker(LoopSession, config))
    node.diagnostics.add("loops", lambda: loop_status(mapper))
    return mapper


def loop_status(mapper: ClosingMapper) -> Status:
    """Return whether loops are closed."""
    graph = mapper.graph
    values = {
        "nodes": graph.num_nodes,
        "loops closed": graph.num_loops,
        "candidates refused": graph.num_refused,
        "maps made anew": graph.num_rebuilt,
        "events behind": mapper.num_behind,
    }
    if mapper.failure:
        return Status(WARN, f"loops are closed no longer: {mapper.failure}", values)
    return Status(OK, "loops are closed in the background", values)
