"""Which landmark of its class each bearing to one belongs to."""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import bearing_residual


@numba.njit(cache=True)
def nearest_marks(
    x: np.ndarray, cov: np.ndarray, mark_robot: np.ndarray, mark_kind: np.ndarray,
    mark_bearing: np.ndarray, mark_var: np.ndarray, marks: np.ndarray, kind_start: np.ndarray,
    gate: float,
) -> np.ndarray:  # fmt: skip
    """Return the landmark of each bearing, (K,), as a row of `marks`; -1 for none.

    The only landmark of its class needs no pose to be known, and is kept whatever the pose says:
    the pose may be wrong. Of several the nearest counts, if it is within the gate and clearly
    nearer than the next.
    """
    result = np.full(len(mark_robot), -1, dtype=np.int64)
    for k in range(len(mark_robot)):
        first, last = kind_start[mark_kind[k]], kind_start[mark_kind[k] + 1]
        if last - first == 1:
            result[k] = first
            continue
        least, second = np.inf, np.inf
        i = mark_robot[k]
        p = 3 * i
        for m in range(first, last):
            e, a, b = bearing_residual(
                x[i, 0], x[i, 1], x[i, 2], marks[m, 0], marks[m, 1], mark_bearing[k]
            )
            v = a * a * cov[p, p] + b * b * cov[p + 1, p + 1] + cov[p + 2, p + 2]
            v += 2.0 * (a * b * cov[p, p + 1] + a * cov[p, p + 2] + b * cov[p + 1, p + 2])
            squared = e * e / (v + mark_var[k])
            if squared < least:
                least, second, result[k] = squared, least, m
            else:
                second = min(second, squared)
        if least > gate * gate or second - least < 4.0:
            result[k] = -1
    _drop_doubles(result, mark_robot)
    return result


@numba.njit(cache=True)
def _drop_doubles(seen: np.ndarray, mark_robot: np.ndarray) -> None:
    """Leave out landmarks that two bearings of one robot claim: one of them is false."""
    for k in range(len(seen)):
        is_doubled = False
        for m in range(k + 1, len(seen)):
            if seen[k] >= 0 and mark_robot[m] == mark_robot[k] and seen[m] == seen[k]:
                seen[m] = -1
                is_doubled = True
        if is_doubled:
            seen[k] = -1
