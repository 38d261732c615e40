"""The voxel map of a simulator's world, made from its solids: nothing in it is measured."""

from __future__ import annotations

from floornav_common.reporting import say
from multi_localizer.voxel_map import VoxelMap
from sim_bridge.world import load_world
from sim_bridge.world_voxels import world_voxels


def map_of_world(name: str, cell: float = 0.01, layer: float = 0.16) -> VoxelMap:
    """Return the map of a world, named or by file, in voxels of `cell` x `cell` x `layer`, m."""
    made = world_voxels(load_world(name), cell, layer)
    if made.left_out:
        say(f"left out, glass or balls: {', '.join(made.left_out)}")
    return VoxelMap(made.color, made.occupied, cell, layer, *made.origin)
