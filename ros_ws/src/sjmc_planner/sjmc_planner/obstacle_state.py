"""What is known of the obstacles that may be people: where they are and how they move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tracks:
    """The obstacles of a person's size at one instant, in the base frame of that instant.

    Attributes:
        number: Which one it is: the same one keeps its number, shape (N,), int.
        position: Middle of each, shape (N, 2), m.
        velocity: Over the ground, along the axes of the base, shape (N, 2), m/s.
        cov: Of (x, y, vx, vy), shape (N, 4, 4).
        radius: Of a disk that holds it, shape (N,), m.
        age_s: Since it was first seen, shape (N,), s.
        unseen_s: Since it was last seen, 0 for now, shape (N,), s.
        is_moving: Probability that it moves at all, shape (N,); `velocity` is weighed by it.
        beam_track: Which of them each beam of the newest scan met: its row in the arrays above,
            -1 for none, shape (number of beams,), int.
    """

    number: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    cov: np.ndarray
    radius: np.ndarray
    age_s: np.ndarray
    unseen_s: np.ndarray
    is_moving: np.ndarray
    beam_track: np.ndarray

    def __len__(self) -> int:
        return len(self.number)


def no_tracks(num_beams: int) -> Tracks:
    """Return the tracks of a scan in which nobody is known."""
    none = np.zeros(0)
    return Tracks(
        np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 4, 4)),
        none, none, none, none, np.full(num_beams, -1),
    )  # fmt: skip
