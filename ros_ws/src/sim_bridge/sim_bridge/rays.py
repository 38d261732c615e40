"""Batches of rays against the bodies of an engine."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Hits:
    """Where rays end.

    Attributes:
        shares: How far each ray reaches, in shares of its length, shape (N,); inf for no hit.
        normals: Of the surface there, shape (N, 3); zero for no hit.
    """

    shares: np.ndarray
    normals: np.ndarray


def cast_rays(
    engine: Any, client: int, starts: np.ndarray, ends: np.ndarray, mask: int
) -> list[Any]:
    """Return the engine's answers for rays from `starts` to `ends`, each (N, 3), m.

    The engine takes at most 16384 rays at once.
    """
    answers: list[Any] = []
    for k in range(0, len(ends), 16000):
        answers += engine.rayTestBatch(
            starts[k : k + 16000].tolist(),
            ends[k : k + 16000].tolist(),
            collisionFilterMask=mask,
            physicsClientId=client,
        )
    return answers


def shares_of(answers: list[Any]) -> np.ndarray:
    """Return how far rays reach, in shares of their length; inf where nothing is hit."""
    return np.array([hit[2] if hit[0] >= 0 else math.inf for hit in answers])


def hits_of(answers: list[Any]) -> Hits:
    """Return reach and surface normals."""
    return Hits(shares_of(answers), np.array([hit[4] for hit in answers]).reshape(-1, 3))
