"""What the team's filter is told of one picture, and what it made of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sighting:
    """A bearing and what it may belong to.

    Attributes:
        bearing: In base_link, 0 ahead, positive to the left, rad.
        meanings: Names of landmarks or robots: one if it is known, several if not.
    """

    bearing: float
    meanings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Looks:
    """What became of the bearings of one picture.

    Attributes:
        meanings: What each was taken for; "" where that could not be told.
        is_used: Whether each corrected the team, shape (M,).
        deviations: Squared deviation of each from what was expected (chi-squared with 1 degree
            of freedom if all is well); NaN where nothing was expected. Shape (M,).
    """

    meanings: tuple[str, ...]
    is_used: np.ndarray
    deviations: np.ndarray
