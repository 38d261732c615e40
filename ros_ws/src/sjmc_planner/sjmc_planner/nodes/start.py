"""The executables that are nodes; each imports its node once a signal can end it cleanly."""

from floornav_common.start import start_node


def local_planner() -> int:
    """Start the node `local_planner`."""
    return start_node("sjmc_planner.nodes.local_planner_node")


def send_goal() -> int:
    """Start the node `send_goal`."""
    return start_node("sjmc_planner.nodes.send_goal_node")


def wavefront_planner() -> int:
    """Start the node `wavefront_planner`."""
    return start_node("sjmc_planner.nodes.wavefront_planner_node")
