"""Simulated worlds and robots: a core that imports no ROS, and one thin node."""
