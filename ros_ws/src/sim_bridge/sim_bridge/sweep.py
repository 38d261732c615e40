"""Where a robot was while a scan was taken beam by beam."""

from __future__ import annotations

import numpy as np

from sim_bridge.config import LaserConfig
from sim_bridge.drive import Velocity


def beam_lags(config: LaserConfig) -> np.ndarray:
    """Return how long before the end of its sweep each beam is taken, s.

    Shape (N,), or (1,) where all are taken at once.
    """
    if config.sweep_s == 0.0:
        return np.zeros(1)
    return np.linspace(config.sweep_s, 0.0, config.num_beams)


def earlier_poses(velocity: Velocity, lags: np.ndarray) -> np.ndarray:
    """Return where a base was some time ago, in its frame of now, shape (N, 4, 4).

    Args:
        velocity: Of the base, steady meanwhile: an exact arc.
        lags: How long ago, shape (N,), s.
    """
    turns = -velocity.yaw_rate * lags
    c, s = np.cos(turns), np.sin(turns)
    # Along the middle direction, with the chord of the arc.
    chords = -lags * np.sinc(turns / (2.0 * np.pi))
    ahead, aside = np.cos(turns / 2.0), np.sin(turns / 2.0)
    T = np.tile(np.eye(4), (len(lags), 1, 1))
    T[:, 0, 0], T[:, 0, 1], T[:, 1, 0], T[:, 1, 1] = c, -s, s, c
    T[:, 0, 3] = chords * (velocity.speed * ahead - velocity.side_speed * aside)
    T[:, 1, 3] = chords * (velocity.speed * aside + velocity.side_speed * ahead)
    return T
