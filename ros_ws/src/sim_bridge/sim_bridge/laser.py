"""From exact distances along beams to what a laser range finder reports (REP 117)."""

from __future__ import annotations

import numpy as np

from floornav_common.scan import Scan
from sim_bridge.config import LaserConfig


def beam_angles(config: LaserConfig) -> np.ndarray:
    """Return the bearing of each beam in the laser frame, shape (N,), rad, middle forward."""
    return -config.fov_rad / 2.0 + angle_increment(config) * np.arange(config.num_beams)


def angle_increment(config: LaserConfig) -> float:
    """Return the step from beam to beam, rad."""
    return config.fov_rad / (config.num_beams - 1)


def beam_directions(config: LaserConfig) -> np.ndarray:
    """Return unit vectors along the beams in the laser frame, shape (N, 3)."""
    angles = beam_angles(config)
    return np.column_stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)))


def measure(config: LaserConfig, distances: np.ndarray, rng: np.random.Generator) -> Scan:
    """Return the scan a laser makes of exact distances.

    Args:
        config: The laser.
        distances: Along each beam, shape (N,), m; inf where nothing is hit.
        rng: Source of noise and dropouts. The same count of numbers is drawn for every scan.
    """
    noise = config.noise_sd_m * rng.standard_normal(len(distances))
    is_lost = rng.random(len(distances)) < config.dropout_share
    ranges = distances + noise
    if config.quantum_m > 0.0:
        ranges = np.round(ranges / config.quantum_m) * config.quantum_m
    ranges = np.where(ranges < config.range_min_m, -np.inf, ranges)
    ranges = np.where(ranges > config.range_max_m, np.inf, ranges)
    ranges = np.where(is_lost, np.nan, ranges)
    return Scan(
        ranges=ranges.astype(np.float32),
        angle_min=-config.fov_rad / 2.0,
        angle_increment=angle_increment(config),
        range_min=config.range_min_m,
        range_max=config.range_max_m,
    )
