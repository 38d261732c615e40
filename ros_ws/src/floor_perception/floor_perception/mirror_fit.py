"""A mirror's curve from measured radii and distances on the floor (floor paper, section 5).

With gamma = C / (H A), xi = B sqrt(C) / A and the viewpoint's height H, eq. 26 turned round is

    R = gamma r / (H + xi sqrt(r^2 + H^2)),

rising from gamma / (H (1 + xi)) px per m at the center to the horizon at gamma / xi. This is what
is fitted, to the radii: the error of a measurement is in the pixels, as the paper's weights say
(errors of the distances would weigh only the farthest). No scale of A, B and C is hidden from the
data, but with sqrt(C) far above R two combinations of the three decide the curve: radii good to
0.1 px leave A open by more than its own size, where r = f(R) is known to 1 %. So gamma, xi and H
are what is compared, and intervals of f(R) are given beside those of A, B, C. A measured H helps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from floor_perception.fit_statistics import FitStatistics, fit_statistics, numeric_jacobian

MIN_RADII = 4
MIN_BAND = 0.25
"""Least share of the largest radius that the radii must span."""
SLACK_PX, SLACK_SHARE = 3.0, 0.02
"""How far a radius may lie below one of a nearer distance: what pixels and tape may err."""
MAX_RMS = 0.1
"""Of the radii's span: what lies farther off is no mirror's curve."""
OUTLIER_SD = 4.0
_MM = 1000.0
_MAX_LOG = 30.0
NAMES = ("gamma_px", "xi", "height_m")


@dataclass(frozen=True)
class MirrorFit:
    """A fitted mirror.

    Attributes:
        parameters: gamma_px, xi and height_m, fitted or given, shape (3,).
        statistics: Of those that were fitted.
        residuals_px: Measured less fitted radius, in the order of the data, shape (N,).
    """

    parameters: np.ndarray
    statistics: FitStatistics
    residuals_px: np.ndarray

    @property
    def gamma_px(self) -> float:
        """Focal length of the unified model."""
        return float(self.parameters[0])

    @property
    def xi(self) -> float:
        """Mirror parameter of the unified model; below 1 for a hyperboloid."""
        return float(self.parameters[1])

    @property
    def height_m(self) -> float:
        """Height of the viewpoint over the floor."""
        return float(self.parameters[2])

    @property
    def rms_px(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residuals_px**2)))

    @property
    def horizon_radius(self) -> float:
        """Pixel radius of the horizon."""
        return self.gamma_px / self.xi

    def abc(self) -> FitStatistics:
        """Return A, B and C of eq. 26 with their statistics.

        Raises:
            ValueError: xi is not below 1: the mirror is no hyperboloid.
        """
        if self.xi >= 1.0:
            raise ValueError(f"xi = {self.xi:.4f} is not below 1: eq. 26 does not hold")
        return self.functions(("a_px_per_mm", "b_per_mm", "c_px2"), abc_of)

    def floor_distance(self, radius_px: np.ndarray) -> FitStatistics:
        """Return r = f(R), m, with its statistics; inf from the horizon on."""
        R = np.asarray(radius_px, dtype=float)
        return self.functions(tuple(f"{v:g} px" for v in R), lambda p: _distance(p, R))

    def outliers(self) -> np.ndarray:
        """Return the indices of measurements that lie far off the others' curve."""
        sd = max(1.4826 * float(np.median(np.abs(self.residuals_px))), 0.1)
        return np.flatnonzero(np.abs(self.residuals_px) > OUTLIER_SD * sd)

    def functions(
        self, names: tuple[str, ...], function: Callable[[np.ndarray], np.ndarray]
    ) -> FitStatistics:
        """Return the statistics of functions of gamma_px, xi and height_m."""
        free = [NAMES.index(name) for name in self.statistics.names]
        with np.errstate(invalid="ignore"):  # inf less inf above the horizon
            slopes = numeric_jacobian(function, self.parameters)[:, free]
            return self.statistics.of(names, function(self.parameters), slopes)


def mirror_radius(distance: np.ndarray, gamma: float, xi: float, height: float) -> np.ndarray:
    """Return the pixel radius at which the floor is seen at a distance, m: eq. 26 turned round."""
    return np.asarray(gamma * distance / (height + xi * np.hypot(distance, height)))


def fit_mirror(
    radii_px: np.ndarray,
    distances_m: np.ndarray,
    height_m: float | None = None,
    xi: float | None = None,
) -> MirrorFit:
    """Fit a mirror's curve to measured radii and floor distances.

    Args:
        radii_px: Radii from the mirror's center in the image, shape (N,).
        distances_m: Distances on the floor from below the viewpoint, shape (N,).
        height_m: Height of the viewpoint over the floor where it is known, m.
        xi: The mirror's parameter where it is known.

    Raises:
        ValueError: Values that are not positive and finite, fewer than 4 different radii or
            distances, radii in a narrow band, distances that do not grow with the radii, or a
            curve that no mirror has.
    """
    R, r = np.asarray(radii_px, dtype=float), np.asarray(distances_m, dtype=float)
    _require_spread(R, r)
    given = np.array([np.nan, *(np.nan if g is None else g for g in (xi, height_m))])
    if not (np.isnan(given) | ((given > 0.0) & np.isfinite(given))).all():
        raise ValueError(f"xi and height_m must be > 0 and finite, got {xi} and {height_m}")
    free, parameters = np.isnan(given), nearest_mirror(R, r, given)
    residuals = R - mirror_radius(r, *parameters)
    rms = float(np.sqrt(np.mean(residuals**2)))
    if rms > MAX_RMS * np.ptp(R):
        raise ValueError(f"no mirror's curve: the best one is {rms:.1f} px off (RMS)")
    jacobian = numeric_jacobian(lambda p: mirror_radius(r, *p), parameters)[:, free]
    names = [name for name, is_free in zip(NAMES, free, strict=True) if is_free]
    statistics = fit_statistics(names, parameters[free], residuals, jacobian)
    return MirrorFit(parameters, statistics, residuals)


def nearest_mirror(R: np.ndarray, r: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Return gamma, xi and H of the curve nearest to radii, px, and distances, m; no checks.

    Args:
        R: Radii, shape (N,).
        r: Distances, shape (N,).
        given: gamma, xi and H where they are known, NaN where not.
    """
    free = np.isnan(given)
    solved = [_solve(R, r, start, free) for start in _starts(R, r, given)]
    return min(solved, key=lambda found: found[1])[0]


def abc_of(parameters: np.ndarray) -> np.ndarray:
    """Return A, B, C: f^2 = H^2 A^2 (1 - xi^2), gamma = f^2 / (H A), B f = xi A."""
    gamma, xi, H = parameters * (1.0, 1.0, _MM)
    A = gamma / (H * (1.0 - xi**2))
    f = gamma / np.sqrt(1.0 - xi**2)
    return np.array([A, xi * A / f, f**2])


def _distance(parameters: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Return r: H tan(theta) of the ray on the sphere at rho = R / gamma."""
    gamma, xi, H = parameters
    rho2 = (R / gamma) ** 2
    factor = (xi + np.sqrt(np.maximum(1.0 + (1.0 - xi**2) * rho2, 0.0))) / (rho2 + 1.0)
    fall = factor - xi
    safe = np.where(fall > 0.0, fall, 1.0)
    return np.where(fall > 0.0, H * factor * R / gamma / safe, np.inf)


def _starts(R: np.ndarray, r: np.ndarray, given: np.ndarray) -> list[np.ndarray]:
    """Return starting values: the horizon a little beyond the largest radius."""
    heights = np.median(r) * np.array((0.2, 0.5, 1.0)) if np.isnan(given[2]) else given[2:]
    xis = (0.5, 0.9) if np.isnan(given[1]) else (given[1],)
    return [np.array([1.05 * xi * R.max(), xi, H]) for H in heights for xi in xis]


def _solve(
    R: np.ndarray, r: np.ndarray, start: np.ndarray, free: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return parameters and cost from one start; in logarithms, so that they stay positive."""

    def filled(logs: np.ndarray) -> np.ndarray:
        parameters = start.copy()
        parameters[free] = np.exp(np.clip(logs, -_MAX_LOG, _MAX_LOG))
        return parameters

    found = least_squares(
        lambda logs: mirror_radius(r, *filled(logs)) - R,
        np.log(start[free]),
        method="lm", x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=400,
    )  # fmt: skip
    return filled(found.x), float(found.cost)


def _require_spread(R: np.ndarray, r: np.ndarray) -> None:
    if R.ndim != 1 or R.shape != r.shape:
        raise ValueError(
            f"radii and distances must be lists of one length, got {R.shape}, {r.shape}"
        )
    for name, values in (("radius", R), ("distance", r)):
        bad = np.flatnonzero(~(np.isfinite(values) & (values > 0.0)))
        if len(bad):
            raise ValueError(f"{name} {bad[0] + 1} must be > 0 and finite, got {values[bad[0]]}")
        if len(np.unique(values)) < MIN_RADII:
            raise ValueError(
                f"at least {MIN_RADII} different values of {name} are needed, "
                f"got {len(np.unique(values))}"
            )
    if np.ptp(R) < MIN_BAND * R.max():
        raise ValueError(
            f"the radii lie between {R.min():g} and {R.max():g} px: they must span at least "
            f"{MIN_BAND:.0%} of the largest to tell a curve"
        )
    order = np.lexsort((R, r))
    fallen = np.maximum.accumulate(R[order]) - R[order]
    worst = int(np.argmax(fallen))
    if fallen[worst] > max(SLACK_PX, SLACK_SHARE * R.max()):
        i = order[worst]
        raise ValueError(
            f"radii must grow with the distance: {R[i]:g} px at {r[i]:g} m lies "
            f"{fallen[worst]:g} px below that of a nearer point"
        )
