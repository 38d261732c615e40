"""Cholesky's factor and the inverse of small symmetric matrices, compiled: no thread is started."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, fastmath=True)
def cholesky(A: np.ndarray, L: np.ndarray) -> bool:
    """Write the lower factor of a symmetric matrix into L; False if it is not positive."""
    size = A.shape[0]
    for i in range(size):
        row = L[i]
        for j in range(i + 1):
            other = L[j]
            rest = A[i, j]
            for k in range(j):
                rest -= row[k] * other[k]
            if i > j:
                row[j] = rest / other[j]
            elif rest > 1e-14 * A[i, i]:
                row[i] = np.sqrt(rest)
            else:
                return False
    return True


@numba.njit(cache=True, fastmath=True)
def solve_cholesky(L: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return x of L L^T x = b."""
    size = L.shape[0]
    x = b.copy()
    for i in range(size):
        for k in range(i):
            x[i] -= L[i, k] * x[k]
        x[i] /= L[i, i]
    for i in range(size - 1, -1, -1):
        x[i] /= L[i, i]
        for k in range(i):
            x[k] -= L[i, k] * x[i]
    return x


@numba.njit(cache=True, fastmath=True)
def inverse_cholesky(L: np.ndarray) -> np.ndarray:
    """Return the inverse of L L^T."""
    size = L.shape[0]
    inverse_L = np.zeros_like(L)
    for i in range(size):
        row = inverse_L[i]
        for k in range(i):
            factor = L[i, k]
            if factor != 0.0:
                above = inverse_L[k]
                for j in range(k + 1):
                    row[j] -= factor * above[j]
        for j in range(i):
            row[j] /= L[i, i]
        row[i] = 1.0 / L[i, i]
    inverse = np.zeros_like(L)
    for k in range(size):
        row = inverse_L[k]
        for i in range(k + 1):
            factor = row[i]
            into = inverse[i]
            for j in range(i + 1):
                into[j] += factor * row[j]
    for i in range(size):
        for j in range(i):
            inverse[j, i] = inverse[i, j]
    return inverse
