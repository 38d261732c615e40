"""Where batches of rays end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

BEYOND = 1.05  # rays are this much longer than range_max, so that noise may bring echoes in


@dataclass(frozen=True)
class Hits:
    """Where rays end.

    Attributes:
        shares: How far each ray reaches, in shares of its length, shape (N,); inf for no hit.
        normals: Of the surface there, shape (N, 3); zero for no hit.
        surfaces: What it is made of, as a number of `surfaces.NAMES`, shape (N,); 0 for no hit.
    """

    shares: np.ndarray
    normals: np.ndarray
    surfaces: np.ndarray
