"""The executables that are nodes; each imports its node once a signal can end it cleanly."""

from floornav_common.start import start_node


def sim_bridge() -> int:
    """Start the node `sim_bridge`."""
    return start_node("sim_bridge.nodes.sim_bridge_node")


def route_follower() -> int:
    """Start the node `route_follower`."""
    return start_node("sim_bridge.nodes.route_follower_node")
