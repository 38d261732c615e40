"""Obstacle avoidance that expects people to step aside, with its baselines."""
