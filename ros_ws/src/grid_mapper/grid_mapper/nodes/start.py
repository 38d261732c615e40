"""The executables that are nodes; each imports its node once a signal can end it cleanly."""

from floornav_common.start import start_node


def grid_mapper() -> int:
    """Start the node `grid_mapper`."""
    return start_node("grid_mapper.nodes.grid_mapper_node")
