"""Scan-to-map ICP in the plane, started from dead reckoning (glass paper, section 3).

One iteration of ICP pairs every scan point with the nearest mean of the surface map and takes a
Gauss-Newton step on

    E(T) = sum_i w_i d_i^T W_i d_i + (T - T_pred)^T P^-1 (T - T_pred),
    d_i = mean_i - T p_i,   M_i = C_cell + R C_i R^T,   w_i = 1 / (1 + d_i^T M_i^-1 d_i / width),

iteratively reweighted (Cauchy). M_i is thin across a wall and wide along it; w_i asks by it whether
point and cell belong together. W_i is M_i^-1 with what it says along the wall scaled down once
more by thin/wide, since where along a wall two beams of two scans ended means nothing. The last
term is the dead reckoning with its covariance P: along a bare corridor, where the scan says
nothing, the odometry does. The information reported is that of the sum, less what noisy normals
lend to its weak direction, times a share: points in one cell share that cell's error. Choosing
between basins (`_cost`) counts them by the same share.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from grid_mapper.config import ScanMatcherConfig
from grid_mapper.icp_kernels import register
from grid_mapper.surface_map import SurfaceMap
from grid_mapper.surface_points import SurfacePoints

COARSE_POINTS = 200  # points used at most while the pose is still far off
FINE_POINTS = 600  # and for the last steps: more change the pose by less than its deviation
INDEPENDENT_SHARE = 0.3  # points in one cell share that cell's error
# Noisy normals lend this share of the best seen direction's information to the others.
LEAK_SHARE = 0.01
MIN_INFORMATION = 1e-6  # 1/m^2; less is none
COARSE_WIDTH, FINE_WIDTH = 25.0, 4.0  # of rho, in squared deviations
BASIN_M, BASIN_RAD = 0.2, 0.1  # a start this near to the truth still converges
MAX_STARTS = np.array([1, 1, 3])  # to each side of x, y and yaw


@dataclass(frozen=True)
class MatchResult:
    """Where a scan fits the map.

    Attributes:
        T_map_base: Best pose.
        information: Of (x, y, yaw) in map axes from the scan alone, shape (3, 3), SI.
        overlap: Share of the points that found a partner in the map, 0..1.
        agreement: Mean weight rho' of those pairs, 0..1; 1 when each fits exactly.
        num_pairs: Points paired.
        rms: Weighted root mean square Mahalanobis residual; about 1 when the model holds.
    """

    T_map_base: SE2
    information: np.ndarray
    overlap: float
    agreement: float
    num_pairs: int
    rms: float

    @property
    def weak_direction(self) -> tuple[float, float]:
        """Deviation (m) and bearing (rad, map axes) of the direction the scan says least of."""
        values, axes = np.linalg.eigh(self.information[:2, :2])
        sigma = float("inf") if values[0] <= MIN_INFORMATION else float(values[0] ** -0.5)
        return sigma, float(np.arctan2(axes[1, 0], axes[0, 0]))


class ScanMatcher:
    """Holds the map of surface cells and fits scans to it."""

    def __init__(self, config: ScanMatcherConfig) -> None:
        self.config = config
        self._map = SurfaceMap(config.cell_m)

    @property
    def is_empty(self) -> bool:
        """True until the first scan is inserted."""
        return self._map.grid.num_tiles == 0

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._map.grid.num_bytes

    def match(self, scan: SurfacePoints, T_pred: SE2, cov_pred: np.ndarray) -> MatchResult:
        """Fit a scan, starting at the predicted pose and, if that is vague, round it.

        Args:
            scan: Points in the base frame.
            T_pred: Predicted `T_map_base`.
            cov_pred: Its covariance in map axes, shape (3, 3).

        Returns:
            The best fit; judge it by its shares before you believe it.
        """
        coarse_stride, fine_stride = (
            max(1, -(-len(scan) // num)) for num in (COARSE_POINTS, FINE_POINTS)
        )
        prior = np.linalg.inv(cov_pred)
        coarse = [
            self._register(scan, coarse_stride, start, T_pred, prior, COARSE_WIDTH)
            for start in starting_poses(T_pred, cov_pred)
        ]
        best = coarse[0]
        if len(coarse) > 1:
            best = min(coarse, key=lambda fit: _cost(fit, len(scan), T_pred, prior))
        fit = self._register(scan, fine_stride, best.T_map_base, T_pred, prior, FINE_WIDTH)
        return replace(fit, information=without_leak(fit.information))

    def _register(
        self, scan: SurfacePoints, stride: int, start: SE2, T_pred: SE2, prior: np.ndarray,
        width: float,
    ) -> MatchResult:  # fmt: skip
        config, grid, used = self.config, self._map.grid, scan.every(stride)
        pose, information, num_pairs, weight, error = register(
            used.points, used.covs, used.normals, start.as_array(), T_pred.as_array(),
            prior / stride, grid.fields["cells"], grid.table, grid.corner, config.cell_m,
            config.max_pair_distance_m, width, config.max_iterations, config.stop_step_m,
        )  # fmt: skip
        return MatchResult(
            T_map_base=SE2(*pose),
            information=INDEPENDENT_SHARE * stride * information,
            overlap=float(num_pairs / max(1, len(used))),
            agreement=float(weight / max(1, num_pairs)),
            num_pairs=int(num_pairs * stride),
            rms=float(np.sqrt(error / max(weight, 1e-9))),
        )

    def insert(self, scan: SurfacePoints, T_map_base: SE2) -> None:
        """Add a scan at its pose to the map of surface cells."""
        self._map.insert(scan, T_map_base, self.config.max_points_per_cell)


def _cost(fit: MatchResult, num_points: int, T_pred: SE2, prior: np.ndarray) -> float:
    """Return what a basin costs, to choose between basins.

    The mean log weight stands for all points, unpaired ones included, each worth only its share:
    or many points that err together would outvote odometry.
    """
    off = offset(T_pred, fit.T_map_base)
    mean = -np.log(max(fit.overlap * fit.agreement, 1e-9))
    return float(INDEPENDENT_SHARE * num_points * COARSE_WIDTH * mean + off @ prior @ off)


def without_leak(information: np.ndarray) -> np.ndarray:
    """Return the information of a match less what its best direction lent to the other.

    Args:
        information: Of (x, y, yaw), shape (3, 3), positive semidefinite.

    Returns:
        The same with the weak direction of (x, y) scaled down, shape (3, 3); still semidefinite.
    """
    values, axes = np.linalg.eigh(information[:2, :2])
    kept = np.clip(1.0 - LEAK_SHARE * values[1] / np.maximum(values, 1e-12), 0.0, 1.0)
    P = np.eye(3)
    P[:2, :2] = axes @ np.diag(np.sqrt(kept)) @ axes.T
    return P @ information @ P


def offset(T_a: SE2, T_b: SE2) -> np.ndarray:
    """Return (x, y, yaw) of b less that of a, shape (3,), the turn wrapped."""
    return np.array([T_b.x - T_a.x, T_b.y - T_a.y, wrap_angle(T_b.yaw - T_a.yaw)])


def starting_poses(T_pred: SE2, cov_pred: np.ndarray) -> list[SE2]:
    """Return poses round the prediction, as far out as two deviations, at most MAX_STARTS basins.

    A good prediction gives itself alone; the first pose is always the prediction.
    """
    sigma = np.sqrt(np.diag(cov_pred))
    basin = np.array([BASIN_M, BASIN_M, BASIN_RAD])
    num = np.clip(np.ceil(2.0 * sigma / basin - 1.0), 0, MAX_STARTS).astype(int)
    offsets = [sorted(range(-n, n + 1), key=abs) for n in num]
    return [
        SE2(T_pred.x + i * basin[0], T_pred.y + j * basin[1], T_pred.yaw + k * basin[2])
        for k in offsets[2]
        for j in offsets[1]
        for i in offsets[0]
    ]
