"""How far runs over the five-robot recording are from ground truth, and how sure they were."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.mrclam_recording import TeamRecording
from experiments.mrclam_runs import Track

SKIP_S = 30.0
"""Left out at the beginning."""

CHI2_95 = 7.81
"""95 % of the squared deviations of a true covariance of three are below it."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a run, robots in the order of the recording's.

    Attributes:
        ate: Root mean square position error in the map, not aligned, shape (R,), m.
        yaw_deg: Root mean square yaw error, shape (R,), deg.
        worst: Greatest position error, shape (R,), m.
        located_share: Share of the instants at which the robot's pose was known, shape (R,).
        first_s: When it was first known, after the recording's begin, shape (R,), s.
        nees: Mean of the squared deviations by the reported covariance, shape (R,); 3 if true.
        sure_share: Share of them below `CHI2_95`, shape (R,).
        distances: Position error at every instant, NaN where not compared, shape (T, R), m.
    """

    ate: np.ndarray
    yaw_deg: np.ndarray
    worst: np.ndarray
    located_share: np.ndarray
    first_s: np.ndarray
    nees: np.ndarray
    sure_share: np.ndarray
    distances: np.ndarray


def errors_of(recording: TeamRecording, track: Track, until: float = np.inf) -> Errors:
    """Compare a run with ground truth, the first `SKIP_S` left out.

    Args:
        recording: With the ground truth.
        track: The run.
        until: Compared up to so long after the recording's begin, s.
    """
    after = track.times - recording.start
    is_compared = (after >= SKIP_S) & (after <= until)
    columns, distances = [], []
    for column, log in enumerate(recording.robots.values()):
        truth = log.truth_at(track.times)
        truth[~is_compared] = np.nan
        columns.append(_of_robot(track, column, truth, after))
        far = track.poses[:, column, :2] - truth[:, :2]
        distances.append(np.hypot(far[:, 0], far[:, 1]))
    return Errors(*np.array(columns).T, np.array(distances).T)


def _of_robot(track: Track, column: int, truth: np.ndarray, after: np.ndarray) -> list[float]:
    """Return one robot's errors in the order of the fields of `Errors`."""
    poses = track.poses[:, column]
    is_located = np.isfinite(poses[:, 0])
    first = float(after[np.argmax(is_located)]) if is_located.any() else np.nan
    has_truth = np.isfinite(truth[:, 0])
    both = is_located & has_truth
    if not both.any():
        return [np.nan, np.nan, np.nan, 0.0, first, np.nan, np.nan]
    off = poses[both] - truth[both]
    off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    squares = off[:, 0] ** 2 + off[:, 1] ** 2
    covs = track.covs[both, column]
    nees = np.full(len(off), np.nan)
    if np.all(np.isfinite(covs)):
        nees = np.einsum("ni,ni->n", off, np.linalg.solve(covs, off[:, :, None])[:, :, 0])
    sure = np.nan if np.isnan(nees).any() else float((nees <= CHI2_95).mean())
    return [
        float(np.sqrt(squares.mean())), float(np.degrees(np.sqrt((off[:, 2] ** 2).mean()))),
        float(np.sqrt(squares.max())), float(both.sum() / has_truth.sum()), first,
        float(nees.mean()), sure,
    ]  # fmt: skip
