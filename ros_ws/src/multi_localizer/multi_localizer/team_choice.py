"""From beliefs to identities: which bearings count now, and which robot each is of in the end."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def best_owners(
    candidates: np.ndarray, counts: np.ndarray, beliefs: np.ndarray, num_bearings: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the likeliest robot of each bearing, -1 for none, and the belief in it, (M,) each.

    A robot is at one bearing of another robot only: of two the surer one counts.
    """
    owner = np.full(num_bearings, -1, dtype=np.int64)
    belief = np.zeros(num_bearings)
    for i in range(len(counts)):
        for j in range(len(counts)):
            best = -1
            for c in range(counts[i, j]):
                if best < 0 or beliefs[i, j, c] > beliefs[i, j, best]:
                    best = c
            if best >= 0 and beliefs[i, j, best] > belief[candidates[i, j, best]]:
                owner[candidates[i, j, best]] = j
                belief[candidates[i, j, best]] = beliefs[i, j, best]
    return owner, belief


@numba.njit(cache=True)
def choose(
    owner: np.ndarray, belief: np.ndarray, before: np.ndarray, level: float, new_share: float
) -> np.ndarray:
    """Return the owners that count in the next fit, (M,); -1 for bearings that do not.

    One that counted before stays while it is believed more than not. New ones need a belief of
    `level`, and only the surest share comes in at once: they make the others clearer.
    """
    seen = np.full(len(owner), -1, dtype=np.int64)
    is_new = np.zeros(len(owner), dtype=np.bool_)
    for k in range(len(owner)):
        if owner[k] >= 0 and owner[k] == before[k] and belief[k] > 0.5:
            seen[k] = owner[k]
        elif owner[k] >= 0 and belief[k] >= level:
            is_new[k] = True
    beliefs = np.sort(belief[is_new])[::-1]
    most = max(25, int(new_share * len(owner)))
    least = beliefs[most - 1] if len(beliefs) > most else level
    least = min(least, 0.999)
    for k in range(len(owner)):
        if is_new[k] and belief[k] >= least:
            seen[k] = owner[k]
    return seen
