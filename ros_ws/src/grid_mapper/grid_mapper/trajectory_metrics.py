"""Trajectories as TUM files, and their errors against ground truth (ATE and RPE).

The formulas are a few lines of numpy, so that a mapping run need not import evo, pandas and
matplotlib for them; a test holds them against evo on the same files.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.recordings.ordering import seconds_to_ns

Trajectory = Sequence[tuple[int, SE2]]

MATCH_NS = 10_000_000
"""Poses further apart in time are not compared (evo's default, 0.01 s)."""


@dataclass(frozen=True)
class TrajectoryErrors:
    """Errors against ground truth.

    Attributes:
        ate: Root mean square distance after the best rigid alignment, m.
        rpe: Root mean square error of the motion from one compared pose to the next, m.
        num_compared: Poses compared.
    """

    ate: float
    rpe: float
    num_compared: int


def format_tum(trajectory: Trajectory) -> str:
    """Return lines of `t x y z qx qy qz qw`, whole ns and digits enough to read back equal."""
    lines = []
    for stamp_ns, pose in trajectory:
        half = 0.5 * pose.yaw
        sign = "-" if stamp_ns < 0 else ""
        seconds, ns = divmod(abs(stamp_ns), 1_000_000_000)
        quat = f"{float(np.sin(half))!r} {float(np.cos(half))!r}"
        xy = f"{float(pose.x)!r} {float(pose.y)!r}"
        lines.append(f"{sign}{seconds}.{ns:09d} {xy} 0.0 0.0 0.0 {quat}\n")
    return "".join(lines)


def load_tum(path: Path) -> list[tuple[int, SE2]]:
    """Read a TUM file; the planar part of each pose is kept.

    Raises:
        ValueError: If a line is not `t x y z qx qy qz qw`, or there is none.
    """
    trajectory: list[tuple[int, SE2]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        words = line.replace(",", " ").split()
        if not words or words[0].startswith("#"):
            continue
        try:
            x, y, _, qx, qy, qz, qw = (float(word) for word in words[1:8])
            yaw = np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
            trajectory.append((seconds_to_ns(words[0]), SE2(x, y, float(yaw))))
        except ValueError:
            raise ValueError(
                f"{path} line {number} is not `t x y z qx qy qz qw`: {line[:60]!r}"
            ) from None
    if not trajectory:
        raise ValueError(f"{path} holds no pose")
    return trajectory


def trajectory_errors(
    estimate: Trajectory, truth: Trajectory, tolerance_ns: int = MATCH_NS
) -> TrajectoryErrors:
    """Compare an estimate with ground truth at the nearest stamps.

    Args:
        estimate: Stamps (ns) and poses.
        truth: Stamps (ns) and poses, in their own frame.
        tolerance_ns: Poses further apart in time are not compared.

    Raises:
        ValueError: If fewer than two poses can be compared.
    """
    pairs = _matched(estimate, truth, tolerance_ns)
    if len(pairs) < 2:
        raise ValueError(
            f"only {len(pairs)} poses lie within {tolerance_ns * 1e-9:g} s of the ground truth's"
        )
    points = np.array([[p.x, p.y] for p, _ in pairs])
    truths = np.array([[t.x, t.y] for _, t in pairs])
    T_truth_map = align(points, truths)
    ate = np.sqrt(np.mean(np.sum((T_truth_map @ points - truths) ** 2, axis=1)))
    steps = [
        t0.between(t1).between(p0.between(p1)).distance
        for (p0, t0), (p1, t1) in zip(pairs, pairs[1:], strict=False)
    ]
    return TrajectoryErrors(float(ate), float(np.sqrt(np.mean(np.square(steps)))), len(pairs))


def align(points: np.ndarray, targets: np.ndarray) -> SE2:
    """Return the rigid motion that brings points closest to targets (Umeyama, no scale).

    Args:
        points: Shape (N, 2), m.
        targets: The point each shall come to, shape (N, 2), m.
    """
    center, target_center = points.mean(axis=0), targets.mean(axis=0)
    a, b = points - center, targets - target_center
    yaw = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    turned = SE2(0.0, 0.0, float(yaw)) @ center[np.newaxis, :]
    shift = target_center - turned[0]
    return SE2(float(shift[0]), float(shift[1]), float(yaw))


def path_length(trajectory: Trajectory) -> float:
    """Return the length of the way, m."""
    pairs = zip(trajectory, trajectory[1:], strict=False)
    return float(sum(a.between(b).distance for (_, a), (_, b) in pairs))


def _matched(estimate: Trajectory, truth: Trajectory, tolerance_ns: int) -> list[tuple[SE2, SE2]]:
    ordered = sorted(truth, key=lambda stamped: stamped[0])
    stamps = np.array([stamp_ns for stamp_ns, _ in ordered], dtype=np.int64)
    pairs: list[tuple[SE2, SE2]] = []
    for stamp_ns, pose in sorted(estimate, key=lambda stamped: stamped[0]):
        right = int(np.searchsorted(stamps, stamp_ns))
        around = [i for i in (right - 1, right) if 0 <= i < len(stamps)]
        best = min(around, key=lambda i: abs(int(stamps[i]) - stamp_ns))
        if abs(int(stamps[best]) - stamp_ns) <= tolerance_ns:
            pairs.append((pose, ordered[best][1]))
    return pairs
