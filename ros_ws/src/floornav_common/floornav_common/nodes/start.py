"""The executables that are nodes; each imports its node once a signal can end it cleanly."""

from floornav_common.start import start_node


def live_view() -> int:
    """Start the node `live_view`."""
    return start_node("floornav_common.nodes.live_view_node")
