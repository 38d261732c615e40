"""The executables that are nodes; each imports its node once a signal can end it cleanly."""

from floornav_common.start import start_node


def floor_detector() -> int:
    """Start the node `floor_detector`."""
    return start_node("floor_perception.nodes.floor_detector_node")


def marker_detector() -> int:
    """Start the node `marker_detector`."""
    return start_node("floor_perception.nodes.marker_detector_node")
