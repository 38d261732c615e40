"""Bays between posts along a pane's line: which are glass, and which nobody can tell.

A line is cut into bins, each in one of five states.
"""

from __future__ import annotations

import numpy as np

from grid_mapper.bayes_config import BayesConfig
from grid_mapper.pane_lines import is_supported

NEUTRAL, WEAK, GLASS, OPEN, OPAQUE = 0, 1, 2, 3, 4


def supported(
    states: np.ndarray, echoes: np.ndarray, bins: np.ndarray, config: BayesConfig
) -> np.ndarray:
    """Return which bins of glass keep, between openings, the echoes that a pane needs."""
    is_glass = states == GLASS
    part = np.cumsum(states == OPEN)
    is_carried = np.zeros(len(states), bool)
    for k in np.unique(part[is_glass]):
        mine = echoes[is_glass[bins] & (part[bins] == k)]
        is_carried |= is_glass & (part == k) & is_supported(mine, config)
    return is_carried


def filled(
    states: np.ndarray, is_carried: np.ndarray, max_bins: int, weak_share: float
) -> np.ndarray:
    """Return which bins are glass once bays between glass and glass or opaque bins are filled."""
    is_glass = states == GLASS
    ends = np.flatnonzero(states >= GLASS)
    for a, b in zip(ends[:-1], ends[1:], strict=True):
        kinds = {int(states[a]), int(states[b])}
        if OPEN in kinds or not 1 < b - a <= max_bins + 1:
            continue
        if is_carried[a] or is_carried[b] or (states[a + 1 : b] == WEAK).mean() >= weak_share:
            is_glass[a + 1 : b] = True
    return np.asarray(is_glass)


def in_doubt(states: np.ndarray, is_start: np.ndarray, max_bins: int, post_bins: int) -> np.ndarray:
    """Return which bins may be glass as well as open: bays that follow on glass, post by post.

    A front of glass goes on from post to post, and of a bay that no sonar ever faced the laser
    sees only the posts. A wall, a longer gap and what was found open end the row.

    Args:
        states: Of the bins, shape (N,).
        is_start: Where rows start: what was found to be glass, shape (N,).
        max_bins: The longest bay.
        post_bins: The longest post; what is opaque over more is a wall.
    """
    kinds = np.where(is_start, GLASS, np.where(states == WEAK, NEUTRAL, states))
    cuts = np.flatnonzero(np.diff(kinds)) + 1
    runs = list(zip(np.r_[0, cuts], np.r_[cuts, len(kinds)], strict=True))
    doubt = np.zeros(len(states), bool)
    for ordered in (runs, runs[::-1]):
        follows = False
        for (a, b), after in zip(ordered, [*ordered[1:], None], strict=True):
            kind = kinds[a]
            is_bay = kind == NEUTRAL and b - a <= max_bins and after is not None
            if kind == GLASS:
                follows = True
            elif is_bay and kinds[after[0]] != OPEN:  # type: ignore[index]
                doubt[a:b] |= follows
            elif kind != OPAQUE or b - a > post_bins:
                follows = False
    return doubt
