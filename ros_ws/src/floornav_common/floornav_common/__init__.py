"""What two floornav packages share: SE(2), scans, grids, configuration, and (in `ros`) ROS glue."""
