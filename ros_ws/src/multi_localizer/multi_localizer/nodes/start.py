"""The executables that are nodes; each imports its node once a signal can end it cleanly."""

from floornav_common.start import start_node


def floor_localizer() -> int:
    """Start the node `floor_localizer`."""
    return start_node("multi_localizer.nodes.floor_localizer_node")


def landmark_localizer() -> int:
    """Start the node `landmark_localizer`."""
    return start_node("multi_localizer.nodes.landmark_localizer_node")


def stereo_localizer() -> int:
    """Start the node `stereo_localizer`."""
    return start_node("multi_localizer.nodes.stereo_localizer_node")


def stereo_matcher() -> int:
    """Start the node `stereo_matcher`."""
    return start_node("multi_localizer.nodes.stereo_matcher_node")


def team_localizer() -> int:
    """Start the node `team_localizer`."""
    return start_node("multi_localizer.nodes.team_localizer_node")
