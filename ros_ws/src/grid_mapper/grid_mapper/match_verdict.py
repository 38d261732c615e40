"""What became of a scan: whether its match to the map is believed and, if not, why in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.scan_matcher import MatchResult, offset


@dataclass(frozen=True)
class ScanResult:
    """What became of a scan.

    Attributes:
        T_map_base: Pose of the robot at the scan's stamp.
        cov: Of (x, y, yaw) in map axes, shape (3, 3), SI.
        is_trusted: False where the match was refused and the pose is the prediction.
        reason: Why it was refused; "" if trusted.
        overlap: Share of the scan's points that found the map, 0..1; 1 for the first scan.
        note: What a trusted match does not say, such as the way along a corridor; "" if nothing.
        information: Of the match alone, (x, y, yaw) in map axes, shape (3, 3); None without one.
    """

    T_map_base: SE2
    cov: np.ndarray
    is_trusted: bool
    reason: str
    overlap: float
    note: str = ""
    information: np.ndarray | None = None


def first_verdict(
    num_points: int, T_map_start: SE2, start_cov: np.ndarray | None, config: GridMapperConfig
) -> ScanResult:
    """Return where the first scan of a map is: where it was said to be, if it shows anything.

    Args:
        num_points: Of the scan.
        T_map_start: Said pose.
        start_cov: Its covariance; None for that of standing still.
        config: How many points it takes.
    """
    sigmas = [config.motion.base_m, config.motion.base_m, config.motion.base_rad]
    cov = np.diag(sigmas) ** 2 if start_cov is None else start_cov
    if num_points < config.min_pairs:
        reason = f"only {num_points} points in the first scan"
        return ScanResult(T_map_start, cov, False, reason, 0.0)
    return ScanResult(T_map_start, cov, True, "", 1.0)


def is_found(match: MatchResult, config: GridMapperConfig) -> bool:
    """Tell whether a match is good enough to say where a robot is that did not know."""
    return (
        match.num_pairs >= config.min_pairs
        and match.overlap >= config.lost_overlap
        and match.agreement >= config.lost_agreement
    )


def objection(
    match: MatchResult, num_points: int, T_pred: SE2, near: np.ndarray, config: GridMapperConfig
) -> str:
    """Return why a match is not to be believed; "" if it is.

    Args:
        match: Of the scan, near the prediction.
        num_points: Of the scan.
        T_pred: The predicted pose in the map.
        near: Covariance of the prediction since the last trusted scan, (x, y, yaw), shape (3, 3).
        config: Its limits.
    """
    off = offset(T_pred, match.T_map_base)
    sigmas = float(np.sqrt(off @ np.linalg.solve(near, off)))
    is_far = near[0, 0] + near[1, 1] > 2.0 * config.vague_sigma_m**2
    is_vague = is_far or near[2, 2] > config.vague_sigma_rad**2
    if num_points < config.min_pairs:
        return f"the scan has {num_points} points, fewer than {config.min_pairs}"
    if match.num_pairs < config.min_pairs or match.overlap < config.min_overlap:
        return f"{match.num_pairs} of the scan's {num_points} points are near the map"
    if match.agreement < config.min_agreement:
        return (
            f"points near the map do not lie on it: agreement {match.agreement:.2f}, "
            f"{config.min_agreement:.2f} is asked"
        )
    if match.overlap < config.sure_overlap and sigmas > config.max_correction_sigmas:
        return f"a match of few points is {sigmas:.1f} deviations from the prediction"
    if is_vague and not is_found(match, config):
        return f"lost, and {100 * match.overlap:.0f} % of the scan fits the map"
    return ""


def blind(match: MatchResult, cov: np.ndarray, config: GridMapperConfig) -> str:
    """Return why a match is refused that leaves a direction nobody has measured for long.

    Args:
        match: Of a scan that came without odometry.
        cov: Of the predicted pose, (x, y, yaw) in map axes, shape (3, 3).
        config: Its limits.
    """
    note = undetermined(match, config)
    _, bearing = match.weak_direction
    u = np.array([np.cos(bearing), np.sin(bearing)])
    sigma = float(np.sqrt(u @ cov[:2, :2] @ u))
    return note if sigma > config.vague_sigma_m else ""


def undetermined(match: MatchResult, config: GridMapperConfig) -> str:
    """Return the direction a match says nothing of, in words; "" if it says where."""
    sigma, bearing = match.weak_direction
    if sigma <= config.undetermined_sigma_m:
        return ""
    return f"the scan does not say where along {np.rad2deg(bearing):.0f} deg the robot is"


def found_words(pose: SE2, after_s: float) -> str:
    """Return where a robot was found, in the map, and how long it was looked for."""
    place = f"x {pose.x:.2f} m, y {pose.y:.2f} m, yaw {np.rad2deg(pose.yaw):.0f} deg"
    return f"found at {place} after {after_s:.1f} s"
