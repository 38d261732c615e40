"""What consumers of ROS topics publish as their rules, and whether messages hold to them."""
