"""Whether two places are the same, and how they lie to each other: a false loop ruins a map.

Correlative search over the window that the graph leaves open, then the fine matcher from each
peak. Refused is what overlaps or agrees too little, what one place sees through where the other
has walls, what fits about as well elsewhere, and what the graph is sure is not so. A match that
slides is refused where the graph does not know better, and else has no weight along its way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from grid_mapper.config import ScanMatcherConfig
from grid_mapper.correlative_search import find_peaks, is_same_peak
from grid_mapper.key_frames import Edge, KeyFrame, place_of
from grid_mapper.loop_candidates import SIGMAS, Candidate
from grid_mapper.loop_config import LoopConfig
from grid_mapper.motion import rotated
from grid_mapper.scan_matcher import MatchResult, ScanMatcher
from grid_mapper.surface_points import SurfacePoints

NUM_PEAKS = 4
BASE_WINDOW = (0.2, 0.05)
"""Searched where the graph is certain too (m, rad)."""
START_COV = np.diag([0.1, 0.1, 0.05]) ** 2
"""How far the fine matcher goes from a peak."""
SEEN_THROUGH_M = 0.3
"""A beam that goes this much further than a wall contradicts it."""
WEAK_INFORMATION = 1e-2  # 1/m^2 or 1/rad^2; a direction that nothing says more of


@dataclass(frozen=True)
class Verdict:
    """What became of a candidate: a loop, or why it is none."""

    edge: Edge | None
    reason: str = ""


def verify(
    frames: Sequence[KeyFrame], poses: Sequence[SE2], candidate: Candidate, config: LoopConfig,
    matcher_config: ScanMatcherConfig,
) -> Verdict:  # fmt: skip
    """Compare two places; where the graph is known to be right, the query's scan alone.

    Args:
        frames: Of all nodes.
        poses: Of all nodes, as the graph has them.
        candidate: The two nodes, and how uncertain they are to each other.
        config: When a loop is believed.
        matcher_config: Of the fine matcher.
    """
    later, number = candidate.query, candidate.reference
    is_known = candidate.sigma_m == 0.0
    query, reference = (
        place_of(frames, poses, _round(center, len(frames), num), center)
        for center, num in (
            (later, 0 if is_known else config.submap_nodes),
            (number, config.submap_nodes),
        )
    )
    T_pred = poses[number].between(poses[later])
    fits = _fits(reference, query, T_pred, candidate, config, matcher_config)
    if not fits:
        return Verdict(None, "nothing to compare")
    best = fits[0]
    reason = _objection(best, fits[1:], T_pred, candidate, config) or _seen_through(
        frames, number, later, reference, query, best.T_map_base, config
    )
    if reason:
        return Verdict(None, reason)
    return Verdict(Edge(number, later, best.T_map_base, _cov(best, config), is_loop=True))


def _round(center: int, num_frames: int, num: int) -> range:
    """Return the node and up to `num` to each side of it."""
    return range(max(0, center - num), min(num_frames, center + num + 1))


def _fits(
    reference: SurfacePoints, query: SurfacePoints, T_pred: SE2, candidate: Candidate,
    config: LoopConfig, matcher_config: ScanMatcherConfig,
) -> list[MatchResult]:  # fmt: skip
    """Return where the query fits the reference, the best first."""
    window = (
        min(BASE_WINDOW[0] + SIGMAS * candidate.sigma_m, config.max_search_m),
        min(BASE_WINDOW[1] + SIGMAS * candidate.sigma_rad, float(np.pi)),
    )
    starts = [T_pred]
    if candidate.sigma_m > 0.0:
        peaks = find_peaks(reference.points, query.points, T_pred, window, NUM_PEAKS)
        starts = [peak.pose for peak in peaks]
    matcher = ScanMatcher(matcher_config)
    matcher.insert(reference, SE2.identity())
    fits = [matcher.match(query, start, START_COV) for start in starts]
    return sorted(fits, key=lambda fit: -fit.overlap * fit.agreement)


def _objection(
    best: MatchResult, others: list[MatchResult], T_pred: SE2, candidate: Candidate,
    config: LoopConfig,
) -> str:  # fmt: skip
    if best.overlap < config.min_overlap:
        return "overlap"
    if best.agreement < config.min_agreement:
        return "agreement"
    off = T_pred.between(best.T_map_base)
    if off.distance > SIGMAS * candidate.sigma_m + BASE_WINDOW[0]:
        return "distance"
    if abs(off.yaw) > SIGMAS * candidate.sigma_rad + BASE_WINDOW[1]:
        return "turn"
    if candidate.sigma_m > config.sure_sigma_m and best.weak_direction[0] > config.sure_sigma_m:
        return "slides"
    quality = best.overlap * best.agreement
    for other in others:
        is_other = not is_same_peak(best.T_map_base, other.T_map_base)
        if is_other and other.overlap * other.agreement > config.max_second_peak * quality:
            return "ambiguous"
    return ""


def _seen_through(
    frames: Sequence[KeyFrame], number: int, later: int, reference: SurfacePoints,
    query: SurfacePoints, T_there_here: SE2, config: LoopConfig,
) -> str:  # fmt: skip
    """Return a reason if beams of one place pass where the other has walls."""
    T_here_there = T_there_here.inverse()
    shares = (
        seen_through(frames[later], reference.moved(T_here_there)),
        seen_through(frames[number], query.moved(T_there_here)),
    )
    return "seen through" if max(shares) > config.max_contradiction else ""


def seen_through(frame: KeyFrame, points: SurfacePoints) -> float:
    """Return the share of points that a scan sees through, of those that it could see.

    Args:
        frame: Whose scan looks.
        points: In its base frame.
    """
    scan = frame.scan
    seen = points.moved(frame.T_base_laser.inverse())
    return float(
        _share_seen_through(
            np.ascontiguousarray(seen.points), np.ascontiguousarray(seen.normals), scan.ranges,
            scan.angle_min, scan.angle_step, scan.range_max, SEEN_THROUGH_M,
        )
    )  # fmt: skip


def _cov(fit: MatchResult, config: LoopConfig) -> np.ndarray:
    """Return the covariance of a loop in the axes of its second node."""
    cov = np.linalg.inv(fit.information + WEAK_INFORMATION * np.eye(3))
    floor = np.diag([config.loop_sigma_m, config.loop_sigma_m, config.loop_sigma_rad]) ** 2
    return rotated(cov, -fit.T_map_base.yaw) + floor


def are_apart(a: Edge, b: Edge, submap_nodes: int) -> bool:
    """Tell whether two loops are of other scans, at both ends: only then the two say more than one.

    A place that looks like another looks so from the next node too, as most of its scans are the
    same ones.
    """
    ends = abs(a.first - b.first), abs(a.second - b.second)
    # The later place was the newest: of the nodes round it there were those before.
    return ends[0] > 2 * submap_nodes and ends[1] > submap_nodes


def agree(a: Edge, b: Edge, poses: Sequence[SE2], config: LoopConfig) -> bool:
    """Tell whether two loops say the same, by the graph's motions between their ends."""
    through_a = poses[b.first].between(poses[a.first]) @ a.T_first_second
    expected = through_a @ poses[a.second].between(poses[b.second])
    off = expected.between(b.T_first_second)
    return off.distance < config.agree_m and abs(wrap_angle(off.yaw)) < config.agree_rad


@numba.njit(cache=True)
def _share_seen_through(  # type: ignore[no-untyped-def]
    points, normals, ranges, angle_min, increment, range_max, margin
):
    num_crossed, num_met = 0, 0
    turn = 2.0 * np.pi
    for i in range(len(points)):
        x, y = points[i]
        distance = np.hypot(x, y)
        if normals[i, 0] * x + normals[i, 1] * y > 0.0 or distance > range_max:
            continue  # its back is turned to the laser
        side = 1.0 if increment > 0.0 else -1.0
        angle = (side * (np.arctan2(y, x) - angle_min)) % turn
        beam = int(np.rint(angle / abs(increment)))
        if beam >= len(ranges) or not np.isfinite(ranges[beam]):
            continue
        if ranges[beam] > distance + margin:
            num_crossed += 1
        elif ranges[beam] > distance - margin:
            num_met += 1
    return num_crossed / max(1, num_crossed + num_met)
