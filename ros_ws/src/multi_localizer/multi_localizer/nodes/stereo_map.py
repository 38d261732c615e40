"""The voxel map that a node is started with."""

from __future__ import annotations

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError
from multi_localizer.voxel_map import VoxelMap, load_voxel_map


def load_map(node: FloornavNode, path: str) -> VoxelMap:
    """Read the map that a node's poses are in.

    Raises:
        ParameterError: If there is none, it cannot be read, or it is in another frame.
    """
    frames = node.frames
    try:
        if not path:
            raise ValueError("map_file must name a voxel map; make_voxel_map makes one")
        voxels = load_voxel_map(path)
        if voxels.frame not in (frames.map, frames.map_frame):
            raise ValueError(
                f"{path} is a map in the frame '{voxels.frame}', map_frame is '{frames.map_frame}':"
                f" start with map_frame:={voxels.frame}, or make the map with --frame "
                f"{frames.map_frame}"
            )
    except (ValueError, OSError) as error:
        raise ParameterError(f"{node.get_fully_qualified_name()}: {error}") from error
    return voxels
