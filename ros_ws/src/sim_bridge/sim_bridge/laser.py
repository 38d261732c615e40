"""From exact distances along beams to what a laser range finder reports (REP 117)."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.scan import Scan
from sim_bridge.config import LaserConfig

_SHALLOWEST_EDGE = 0.05  # m; less is lost in the noise


def beam_angles(config: LaserConfig) -> np.ndarray:
    """Return the bearing of each beam in the laser frame, shape (N,), rad, middle forward."""
    return -config.fov_rad / 2.0 + angle_increment(config) * np.arange(config.num_beams)


def angle_increment(config: LaserConfig) -> float:
    """Return the step from beam to beam, rad; the last beam never repeats the first."""
    return config.fov_rad / (config.num_beams - (0 if is_full_turn(config) else 1))


def is_full_turn(config: LaserConfig) -> bool:
    """Tell whether the beam after the last would be the first."""
    return config.fov_rad > 2.0 * math.pi - 1e-4


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
    unit_noise = rng.standard_normal(len(distances))
    is_lost = rng.random(len(distances)) < config.dropout_share
    ranges = with_edges(config, distances, rng.random((2, len(distances))))
    reached = np.where(np.isfinite(ranges), ranges, 0.0)
    sd = np.hypot(config.noise_sd_m, config.noise_sd_share * reached)
    ranges = ranges + sd * unit_noise
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
        time_increment=config.sweep_s / (config.num_beams - 1),
    )


def with_edges(config: LaserConfig, distances: np.ndarray, chance: np.ndarray) -> np.ndarray:
    """Return distances with some beams at edges mixed: a spot on both gives a range between.

    An edge is a gap between what the beams before and after it continue to; corners and slanted
    walls have none.

    Args:
        config: The laser.
        distances: Along each beam, shape (N,), m.
        chance: Uniform numbers, shape (2, N): whether a beam is mixed, and where between.
    """
    known = np.where(np.isfinite(distances), distances, 1e6)
    step = np.roll(known, -1) - known
    if not is_full_turn(config):
        step[-1] = 0.0
    before, after = np.roll(step, 1), np.roll(step, -1)
    slopes = [np.where(np.abs(s) < np.abs(step), s, 0.0) for s in (before, after)]
    gap = np.abs(step - (slopes[0] + slopes[1]) / 2.0)
    is_edge = (gap > _SHALLOWEST_EDGE) & (gap < config.edge_depth_m)
    is_mixed = is_edge & (chance[0] < config.edge_share)
    return np.where(is_mixed, distances + chance[1] * step, distances)
