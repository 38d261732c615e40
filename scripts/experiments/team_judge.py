"""What is said of an answer for a team: errors, identities, whether its covariances are true."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2

from experiments.team_bounds import bound, oracle_ids
from experiments.team_views_sim import Scene
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_confirmed import is_confirmed
from multi_localizer.team_views import NOBODY, TeamSolution

DEGREES_OF_POSE = 3
BAND = 0.95
TAIL_CHI2 = float(chi2.ppf(BAND, DEGREES_OF_POSE))
"""Squared deviations that 5 % of true poses exceed."""
WRONG_CHI2 = 40.0
"""Those that no true pose exceeds."""
LEAST_LAYOUTS = 10
"""Fewer layouts than these give no ratio."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """One layout, judged.

    Attributes:
        errors: Estimate less truth of each robot, (N, 3), yaw wrapped; NaN where no pose was given.
        nees: Of each robot's covariance, (N,); NaN likewise.
        least_var: Cramer-Rao bound of the variance of x, y, yaw of each, (N, 3); None if infinite.
        num_views: Real bearings to robots.
        num_right: Those with the right identity.
        num_wrong: Those with the identity of another robot.
        num_oracle: Those that the oracle gives the right identity.
        num_false: False detections.
        num_refused: Those that were called nobody's.
        is_exact: Whether each bearing, real or false, got its true identity.
        ms: Time of the solve.
        num_suspects: Robots called suspect.
        faulty_chi2: Squared deviations of the faulty robot's pose where it is published; NaN where
            it is not, or no robot is faulty.
        published_chi2: Squared deviations of the honest robots' poses, those that are published.
    """

    errors: np.ndarray
    nees: np.ndarray
    least_var: np.ndarray | None
    num_views: int
    num_right: int
    num_wrong: int
    num_oracle: int
    num_false: int
    num_refused: int
    is_exact: bool
    ms: float
    num_suspects: int
    faulty_chi2: float = math.nan
    published_chi2: tuple[float, ...] = ()


def judge(scene: Scene, solution: TeamSolution, ms: float, *, counts_rough: bool = True) -> Verdict:
    """Hold an answer against the truth.

    Args:
        scene: With the truth.
        solution: What came out.
        ms: How long it took.
        counts_rough: Whether rough poses are evidence of their own.
    """
    honest = [k for k in range(len(scene.views)) if k not in scene.faulty]
    truth = np.concatenate([scene.true_ids[k] for k in honest])
    said = np.concatenate([_said(scene, solution, k) for k in honest])
    best = oracle_ids(scene)
    oracle = np.concatenate([best[k] for k in honest])
    is_real = truth != NOBODY
    errors, nees = _errors(scene, solution, honest)
    return Verdict(
        errors=errors,
        nees=nees,
        least_var=None if scene.faulty else bound(scene, counts_rough=counts_rough),
        num_views=int(is_real.sum()),
        num_right=int((truth == said)[is_real].sum()),
        num_wrong=int(((truth != said) & (said != NOBODY))[is_real].sum()),
        num_oracle=int((truth == oracle)[is_real].sum()),
        num_false=int((~is_real).sum()),
        num_refused=int((said[~is_real] == NOBODY).sum()),
        is_exact=bool(np.all(truth == said)),
        ms=ms,
        num_suspects=len(solution.suspects),
        faulty_chi2=next(iter(_published_chi2(scene, solution, scene.faulty)), math.nan),
        published_chi2=_published_chi2(scene, solution, honest),
    )


def _said(scene: Scene, solution: TeamSolution, robot: int) -> np.ndarray:
    ids = solution.identities.get(scene.layout.names[robot])
    return np.full(len(scene.true_ids[robot]), NOBODY) if ids is None else np.asarray(ids)


def _errors(
    scene: Scene, solution: TeamSolution, robots: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    errors, nees = np.full((len(robots), 3), np.nan), np.full(len(robots), np.nan)
    for k, robot in enumerate(robots):
        estimate = solution.estimates.get(scene.layout.names[robot])
        if estimate is not None:
            off = estimate.pose.as_array() - scene.layout.poses[robot]
            off[2] = (off[2] + np.pi) % (2.0 * np.pi) - np.pi
            errors[k] = off
            nees[k] = off @ np.linalg.solve(estimate.cov, off)
    return errors, nees


def _published_chi2(
    scene: Scene, solution: TeamSolution, robots: Sequence[int]
) -> tuple[float, ...]:
    """Return how wrong the poses of some robots are, those that `team_localizer` would publish."""
    published = [
        robot for robot in robots
        if is_confirmed(solution, scene.views, scene.layout.names[robot], TeamConfig())
    ]  # fmt: skip
    return tuple(float(value) for value in _errors(scene, solution, published)[1])


def figures(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return what many layouts of one kind come to; None where nothing can be said."""
    num_views = sum(v.num_views for v in verdicts)
    num_false = sum(v.num_false for v in verdicts)
    exact = [v for v in verdicts if v.is_exact]
    off = np.concatenate([v.errors for v in verdicts])
    return {
        "layouts": len(verdicts),
        "identified_share": share(sum(v.num_right for v in verdicts), num_views),
        "wrong_share": share(sum(v.num_wrong for v in verdicts), num_views),
        "oracle_share": share(sum(v.num_oracle for v in verdicts), num_views),
        "false_refused_share": share(sum(v.num_refused for v in verdicts), num_false),
        "exact_layouts": len(exact),
        "answered_share": float(np.isfinite(off[:, 0]).mean()),
        "rms_m": rms_position(verdicts),
        "rms_deg": None if np.all(np.isnan(off)) else math.degrees(_rms(off[:, 2])),
        "bound_m": rms_bound(verdicts),
        "crlb_ratio": bound_ratio(exact),
        "crlb_ratio_all": bound_ratio(verdicts),
        **consistency(verdicts),
        "tail_share": _above(np.concatenate([v.nees for v in verdicts]), TAIL_CHI2),
        "nees_identified": consistency(exact)["nees"],
        "solve_ms": float(np.median([v.ms for v in verdicts])),
        "solve_p99_ms": float(np.percentile([v.ms for v in verdicts], 99)),
    }


def faulty_figures(verdicts: Sequence[Verdict]) -> dict[str, float]:
    """Return how often poses are published, and published and wrong: the faulty robot's, others'.

    Shares are of all robots of a kind, also of those that are not published.
    """
    honest = np.concatenate([v.published_chi2 for v in verdicts])
    num_honest = sum(len(v.nees) for v in verdicts)
    values = np.array([v.faulty_chi2 for v in verdicts])
    return {
        "faulty_published_share": float(np.isfinite(values).mean()),
        "faulty_wrong_share": float((values > WRONG_CHI2).mean()),
        "honest_published_share": len(honest) / num_honest,
        "honest_wrong_share": float((honest > WRONG_CHI2).sum()) / num_honest,
    }


def _above(values: np.ndarray, limit: float) -> float | None:
    said = values[np.isfinite(values)]
    return float((said > limit).mean()) if len(said) else None


def share(part: int, whole: int) -> float | None:
    """Return a part of a whole; None of nothing."""
    return part / whole if whole else None


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


def rms_position(verdicts: Sequence[Verdict]) -> float | None:
    """Return the root mean square of the distance to the true place, over robots with a pose."""
    off = np.concatenate([np.hypot(*v.errors[:, :2].T) for v in verdicts]) if verdicts else []
    return None if np.all(np.isnan(off)) else _rms(np.asarray(off))


def rms_bound(verdicts: Sequence[Verdict]) -> float | None:
    """Return the least root mean square distance that an unbiased localizer can have."""
    least = [v.least_var[:, :2].sum(axis=1) for v in verdicts if v.least_var is not None]
    return float(np.sqrt(np.concatenate(least).mean())) if least else None


def bound_ratio(verdicts: Sequence[Verdict]) -> float | None:
    """Return the rms error over the bound's, robots with a pose and a finite bound; None of few."""
    both = [v for v in verdicts if v.least_var is not None and not np.isnan(v.errors).all()]
    if len(both) < LEAST_LAYOUTS:
        return None
    off = np.concatenate([np.square(v.errors[:, :2]).sum(axis=1) for v in both])
    least = np.concatenate([v.least_var[:, :2].sum(axis=1) for v in both])  # type: ignore[index]
    has_pose = np.isfinite(off)
    return float(np.sqrt(off[has_pose].mean() / least[has_pose].mean()))


def consistency(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return the mean NEES of one robot of each layout and its 95 % band.

    Robots of one layout share their errors; of each layout one is taken in turn, so that what is
    averaged is independent.
    """
    one_each = [v.nees[k % len(v.nees)] for k, v in enumerate(verdicts)]
    values = np.array([nees for nees in one_each if np.isfinite(nees)])
    if len(values) < LEAST_LAYOUTS:
        return {"nees": None, "nees_band": None, "nees_kept": None}
    count = DEGREES_OF_POSE * len(values)
    low, high = (float(chi2.ppf(p, count)) / len(values) for p in (0.5 - BAND / 2, 0.5 + BAND / 2))
    mean = float(values.mean())
    return {"nees": mean, "nees_band": [low, high], "nees_kept": low <= mean <= high}
