"""The ROS side: nodes and what they share."""
