"""Who is who in all bearings at once: beliefs by passing messages between pairs and bearings.

Each pair of robots takes one of its pairs of bearings (or one bearing, or none); each bearing
belongs to one pair or to nobody. Messages run between pairs and bearings as in Williams and Lau,
"Approximate evaluation of marginal association probabilities with belief propagation" (2014),
here with variables of pairs: a pair says at which odds it uses a bearing, a bearing says how free
the others leave it.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_pairs import MAX_CANDIDATES, NONE

_MOST = 1e12
_LEAST = 1e-12
_SETTLED = 0.005  # change of the belief that a bearing is anybody's at which messages end


@numba.njit(cache=True)
def beliefs(
    candidates: np.ndarray, counts: np.ndarray, likelihoods: np.ndarray, num_bearings: int,
    rounds: int,
) -> np.ndarray:  # fmt: skip
    """Return how sure each robot's candidates are, (N, N, MAX_CANDIDATES).

    Args:
        candidates: Bearings of i that may be j's, (N, N, MAX_CANDIDATES).
        counts: How many, (N, N).
        likelihoods: As `pair_likelihoods` returns them.
        num_bearings: Of all robots.
        rounds: Messages are passed so many times.
    """
    n = len(counts)
    odds = np.zeros((n, n, MAX_CANDIDATES))
    free = np.ones((n, n, MAX_CANDIDATES + 1))
    claims = np.zeros(num_bearings)
    before = np.zeros(num_bearings)
    sums = np.zeros((2, MAX_CANDIDATES))
    for _ in range(rounds):
        for i in range(n):
            for j in range(i + 1, n):
                if counts[i, j] + counts[j, i] == 0:
                    continue
                _say_odds(
                    likelihoods[i, j], free[i, j], free[j, i], counts[i, j], counts[j, i],
                    odds[i, j], odds[j, i], sums,
                )  # fmt: skip
        _sum_claims(claims, candidates, counts, odds)
        for i in range(n):
            for j in range(n):
                for c in range(counts[i, j]):
                    others = max(claims[candidates[i, j, c]] - odds[i, j, c], 0.0)
                    free[i, j, c] = 1.0 / (1.0 + others)
        if _is_settled(claims, before):
            break
        before[:] = claims
    result = np.zeros((n, n, MAX_CANDIDATES))
    for i in range(n):
        for j in range(n):
            for c in range(counts[i, j]):
                result[i, j, c] = odds[i, j, c] / (1.0 + claims[candidates[i, j, c]])
    return result


@numba.njit(cache=True)
def _is_settled(claims: np.ndarray, before: np.ndarray) -> bool:
    for k in range(len(claims)):
        if abs(claims[k] / (1.0 + claims[k]) - before[k] / (1.0 + before[k])) > _SETTLED:
            return False
    return True


@numba.njit(cache=True)
def _sum_claims(
    claims: np.ndarray, candidates: np.ndarray, counts: np.ndarray, odds: np.ndarray
) -> None:
    claims[:] = 0.0
    for i in range(len(counts)):
        for j in range(len(counts)):
            for c in range(counts[i, j]):
                claims[candidates[i, j, c]] += odds[i, j, c]


@numba.njit(cache=True)
def _say_odds(
    likelihoods: np.ndarray, free_i: np.ndarray, free_j: np.ndarray, num_i: int, num_j: int,
    odds_i: np.ndarray, odds_j: np.ndarray, sums: np.ndarray,
) -> None:  # fmt: skip
    """Write at which odds a pair uses each of its candidates, given how free they are."""
    total = likelihoods[NONE, NONE]
    by_i, by_j = sums[0], sums[1]
    by_j[:num_j] = 0.0
    for c in range(num_i):
        row, free = likelihoods[c], free_i[c]
        of_c = row[NONE]
        for d in range(num_j):
            share = row[d] * free_j[d]
            of_c += share
            by_j[d] += free * share
        by_i[c] = free * of_c
        total += by_i[c]
    for d in range(num_j):
        alone = likelihoods[NONE, d] * free_j[d]
        by_j[d] += alone
        total += alone
    for c in range(num_i):
        rest = max(total - by_i[c], _LEAST * total)
        odds_i[c] = min(by_i[c] / max(free_i[c], _LEAST) / rest, _MOST)
    for d in range(num_j):
        rest = max(total - by_j[d], _LEAST * total)
        odds_j[d] = min(by_j[d] / max(free_j[d], _LEAST) / rest, _MOST)
