"""Make a voxel map for stereo_localizer; `--help` tells the options."""

import sys
from functools import partial

from _environment import ensure_environment

ensure_environment()

from floornav_common.reporting import run_command, say  # noqa: E402
from multi_localizer.make_voxel_map import main  # noqa: E402
from multi_localizer.voxel_map import VoxelMap  # noqa: E402
from sim_bridge.world import load_world  # noqa: E402
from sim_bridge.world_voxels import world_voxels  # noqa: E402


def map_of_world(name: str, cell: float, layer: float) -> VoxelMap:
    """Return the map of a simulator's world: its solids, nothing measured."""
    made = world_voxels(load_world(name), cell, layer)
    if made.left_out:
        say(f"left out, glass or balls: {', '.join(made.left_out)}")
    return VoxelMap(made.color, made.occupied, cell, layer, *made.origin)


if __name__ == "__main__":
    sys.exit(run_command(partial(main, world_maker=map_of_world)))
