"""How far off a laser still hears a surface: by its angle, by what it is made of, by chance."""

from __future__ import annotations

import numpy as np

from sim_bridge.config import LaserConfig
from sim_bridge.surfaces import REFLECTANCE, SURFACES


def echo_reach(
    config: LaserConfig, cos_incidence: np.ndarray, surfaces: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Return the distance at which the echo of each beam drowns in the open, shape (N,), m.

    A surface spreads what falls on it to every side (Lambert): the echo goes with reflectance
    times cosine over squared distance, so the reach with the square root of the first two.
    `reach_factor` is that of plaster met squarely. Surfaces are not all alike: the reach varies
    from beam to beam.

    Args:
        config: The laser.
        cos_incidence: Cosine of the angle between beam and surface normal, shape (N,).
        surfaces: Numbers of `surfaces.NAMES`, shape (N,).
        rng: Source of the variation; the same count of numbers is drawn for every scan.
    """
    share = REFLECTANCE[surfaces] / SURFACES["smooth"].reflectance * np.abs(cos_incidence)
    strength = np.exp(config.echo_log_sd * rng.standard_normal(len(surfaces)))
    return np.asarray(config.reach_factor * config.range_max_m * np.sqrt(share) * strength)
