"""Identities of a team's bearings and the poses they make, as they stand between two steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multi_localizer.team_fit import TeamFit

PLAIN = 1e3
"""A limit in deviations at which no residual counts less."""


@dataclass(frozen=True, eq=False)
class Identification:
    """Identities and the poses they make.

    Attributes:
        owner: Robot that each bearing is likeliest of, (M,); -1 for none.
        belief: How sure that is, (M,).
        seen: The owners that count in the fit, (M,); -1 else.
        mark_seen: Landmark of each bearing to one, (K,); -1 for none.
        prior_weight: What each rough pose counts, (N,).
        fit: Poses and covariance.
        limit: Deviations beyond which a residual counted less in the fit.
    """

    owner: np.ndarray
    belief: np.ndarray
    seen: np.ndarray
    mark_seen: np.ndarray
    prior_weight: np.ndarray
    fit: TeamFit
    limit: float = PLAIN
