"""Scans and odometry to a pose and an occupancy map, live and from recordings."""
