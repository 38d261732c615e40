"""Which mapper the node takes, and what it says of closing loops and of a map to begin with."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

import yaml

from floornav_common.grid import OccupancyMap
from floornav_common.ros.diagnostics import OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError
from grid_mapper.background import ProcessWorker
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_session import LoopSession
from grid_mapper.nodes.node_sessions import StartSession
from grid_mapper.recovery import Recovery
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.start_map import StartMap, load_start_map

MISSING = "loops are not closed: the package gtsam is not installed (requirements-robot.txt)"
WITH_START_MAP = "loops are not closed in a map that was made before: scans are fitted to it"


def make_mapper(
    node: FloornavNode,
    config: GridMapperConfig,
    has_own_poses: bool,
    start: StartMap | None,
    is_frozen: bool,
    session: StartSession | None = None,
) -> LayeredMapper | ClosingMapper:
    """Return the mapper that a node's values ask for, and add what it says to the diagnostics."""
    if start is not None:
        if config.loop_closing:
            node.diagnostics.set("loops", Status(OK, WITH_START_MAP))
        return LayeredMapper(config, start=start, is_frozen=is_frozen)
    if not (config.loop_closing and has_own_poses):
        return LayeredMapper(config)
    if find_spec("gtsam") is None:
        node.get_logger().warning(MISSING)
        node.diagnostics.set("loops", Status(WARN, MISSING))
        return LayeredMapper(config)
    path = "" if session is None else session.path
    mapper = ClosingMapper(config, ProcessWorker(LoopSession, config, path))
    if session is not None:
        mapper.take_up(session.localizer)
    node.diagnostics.add("loops", lambda: loop_status(mapper))
    return mapper


def loop_status(mapper: ClosingMapper) -> Status:
    """Return whether loops are closed."""
    graph = mapper.graph
    values = {
        "nodes": graph.num_nodes,
        "loops closed": graph.num_loops,
        "candidates refused": graph.num_refused,
        "maps made anew": mapper.num_swaps,
        "events behind": mapper.link.num_behind,
        "longest hold-up of a scan (ms)": f"{mapper.longest_hold_up_ms:.1f}",
    }
    if mapper.failure:
        return Status(WARN, f"loops are closed no longer: {mapper.failure}", values)
    return Status(OK, "loops are closed in the background", values)


def read_start_map(config: GridMapperNodeConfig) -> StartMap | None:
    """Return the map to begin with; None where none is asked for.

    Raises:
        ParameterError: If it cannot be read.
    """
    if not config.start_map:
        return None
    try:
        return load_start_map(config.start_map)
    except (ValueError, OSError, yaml.YAMLError) as error:
        words = " ".join(str(error).split())
        raise ParameterError(f"start_map {config.start_map}: {words}") from error


def make_recovery(
    config: GridMapperConfig,
    start: StartMap | None,
    is_frozen: bool,
    mapped: Callable[[], OccupancyMap | None],
) -> Recovery:
    """Return what brings a lost robot back.

    Args:
        config: When to look, and when a place is believed.
        start: The map to begin with.
        is_frozen: Whether that stays as it is; else the robot is looked for in what it became.
        mapped: Gives the newest map; None before the first.
    """

    def current() -> OccupancyMap | None:
        newest = None if is_frozen and start is not None else mapped()
        return start.laser if newest is None and start is not None else newest

    return Recovery(config, lambda: ProcessWorker(Relocalizer, config), current)
