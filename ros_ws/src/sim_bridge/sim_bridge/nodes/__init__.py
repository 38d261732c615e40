"""ROS nodes of sim_bridge."""
