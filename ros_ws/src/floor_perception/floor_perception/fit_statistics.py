"""How well a least-squares fit is determined: covariance, confidence intervals, conditioning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student_t

CONFIDENCE = 0.95
MAX_CONDITION = 1e6
NEAR_CONDITION = 100.0
"""Of the Jacobian with columns of length 1: above it parameters trade off against each other."""


@dataclass(frozen=True)
class FitStatistics:
    """What a fit knows of its parameters.

    Attributes:
        names: Of the parameters, with units.
        values: Their estimates, shape (P,).
        cov: Their covariance, shape (P, P).
        residual_sd: Deviation of one residual, by the fit's own residuals.
        dof: Residuals less parameters.
        condition: Of the Jacobian with columns of length 1.
    """

    names: tuple[str, ...]
    values: np.ndarray
    cov: np.ndarray
    residual_sd: float
    dof: int
    condition: float

    @property
    def half_widths(self) -> np.ndarray:
        """Half the width of each parameter's 95 % confidence interval, shape (P,)."""
        return np.asarray(self.quantile * np.sqrt(np.diag(self.cov)))

    @property
    def quantile(self) -> float:
        """Deviations that a 95 % interval reaches to each side (Student's t)."""
        return float(student_t.ppf(0.5 + CONFIDENCE / 2.0, self.dof))

    @property
    def is_nearly_degenerate(self) -> bool:
        """Whether the parameters trade off: single values mean little, the curve may still do."""
        return self.condition > NEAR_CONDITION

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % confidence interval of a parameter."""
        k = self.names.index(name)
        half = float(self.half_widths[k])
        return float(self.values[k]) - half, float(self.values[k]) + half

    def of(self, names: tuple[str, ...], values: np.ndarray, by_own: np.ndarray) -> FitStatistics:
        """Return the statistics of functions of the parameters, to first order.

        Args:
            names: Of the functions.
            values: Theirs, shape (Q,).
            by_own: Their derivatives by these parameters, shape (Q, P).
        """
        cov = by_own @ self.cov @ by_own.T
        return FitStatistics(names, values, cov, self.residual_sd, self.dof, self.condition)


def fit_statistics(
    names: Sequence[str], values: np.ndarray, residuals: np.ndarray, jacobian: np.ndarray
) -> FitStatistics:
    """Return the statistics at the minimum of a sum of squares of equal weights.

    Args:
        names: Of the parameters.
        values: Their estimates, shape (P,).
        residuals: Shape (N,), N > P.
        jacobian: d(residuals)/d(parameters), shape (N, P).

    Raises:
        ValueError: Too few residuals, or a combination of parameters that they do not determine.
    """
    count, dof = len(residuals), len(residuals) - len(values)
    if dof < 1:
        raise ValueError(f"{count} measured values cannot determine {len(values)} parameters")
    length = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(length > 0.0, length, 1.0)
    _, singular, rows = np.linalg.svd(scaled, full_matrices=False)
    if not (length > 0.0).all() or singular[-1] * MAX_CONDITION < singular[0]:
        weak = np.where(length > 0.0, 0.0, 1.0) if not (length > 0.0).all() else np.abs(rows[-1])
        told = [n for n, w in zip(names, weak, strict=True) if w > 0.3 * weak.max()]
        raise ValueError(f"the data do not determine {', '.join(told)}")
    sd = float(np.sqrt(residuals @ residuals / dof))
    spread = rows.T / singular / length[:, None]
    cov = sd**2 * spread @ spread.T
    condition = float(singular[0] / singular[-1])
    return FitStatistics(tuple(names), np.asarray(values), cov, sd, dof, condition)


def numeric_jacobian(function: object, values: np.ndarray) -> np.ndarray:
    """Return d(function)/d(values) by central differences, shape (..., P)."""
    columns = []
    for k, value in enumerate(values):
        step = np.zeros(len(values))
        step[k] = 1e-6 * max(abs(float(value)), 1e-3)
        difference = function(values + step) - function(values - step)  # type: ignore[operator]
        columns.append(difference / (2.0 * step[k]))
    return np.stack(columns, axis=-1)
