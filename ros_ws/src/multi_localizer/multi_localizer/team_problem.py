"""A team's views as plain arrays, for the compiled steps.

Bearings of all robots stand behind each other; those of robot i are `start[i]:start[i + 1]`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_views import NOBODY, RobotView

UNKNOWN = -2
"""In `TeamProblem.known`: nobody has said whom this bearing belongs to."""
_FAR = 1e6  # deviation of a pose that nobody knows, m


@dataclass(frozen=True, eq=False)
class TeamProblem:
    """Arrays of a team of N robots with M bearings and K bearings to landmarks.

    Attributes:
        names: Of the robots, N.
        start: Where each robot's bearings begin, (N + 1,).
        bearings: (M,), rad.
        var: Variance of each bearing, (M,), rad^2.
        source: Place of each bearing in its view, (M,): NaN ones were left out.
        known: Robot that each bearing is said to belong to, or `UNKNOWN`, (M,).
        mark_robot: Robot of each bearing to a landmark, (K,).
        mark_kind: Its class, as an index of `kinds`, (K,).
        mark_source: Its place in the view's array of the class, (K,).
        mark_bearing: (K,), rad.
        mark_var: (K,), rad^2.
        kinds: Classes of landmarks.
        marks: Positions of all landmarks, (L, 2), m.
        kind_start: Where each class begins in `marks`, (len(kinds) + 1,).
        prior: Rough poses, (N, 3); zeros where there is none.
        prior_info: Inverse covariances of the rough poses, (N, 3, 3); zero where there is none.
        prior_counts: Whether a rough pose is evidence of its own, (N,).
        notes: What was left out.
    """

    names: tuple[str, ...]
    start: np.ndarray
    bearings: np.ndarray
    var: np.ndarray
    source: np.ndarray
    known: np.ndarray
    mark_robot: np.ndarray
    mark_kind: np.ndarray
    mark_source: np.ndarray
    mark_bearing: np.ndarray
    mark_var: np.ndarray
    kinds: tuple[str, ...]
    marks: np.ndarray
    kind_start: np.ndarray
    prior: np.ndarray
    prior_info: np.ndarray
    prior_counts: np.ndarray
    notes: tuple[str, ...]

    @property
    def num_robots(self) -> int:
        """Number of robots."""
        return len(self.names)

    @property
    def has_prior(self) -> np.ndarray:
        """Whether each robot has a rough pose, (N,)."""
        return self.prior_info[:, 0, 0] > 0.0


def make_problem(
    views: Sequence[RobotView], landmarks: Mapping[str, np.ndarray], config: TeamConfig
) -> TeamProblem:
    """Lay out views as arrays.

    Args:
        views: Of all robots, with distinct names.
        landmarks: Positions by class, (K, 2) each, m.
        config: For the deviation where a view names none.
    """
    names = tuple(view.name for view in views)
    kinds = tuple(landmarks)
    notes: list[str] = []
    rows, marks = _robot_rows(views, config, notes), _mark_rows(views, kinds, config, notes)
    prior, info, counts = _priors(views)
    places = [np.asarray(landmarks[kind], dtype=float).reshape(-1, 2) for kind in kinds]
    counted = np.bincount(rows[:, 0].astype(np.int64), minlength=len(views))
    return TeamProblem(
        names=names,
        start=np.concatenate(([0], np.cumsum(counted))).astype(np.int64),
        bearings=np.ascontiguousarray(rows[:, 1]),
        var=np.ascontiguousarray(rows[:, 2]),
        source=rows[:, 3].astype(np.int64),
        known=rows[:, 4].astype(np.int64),
        mark_robot=marks[:, 0].astype(np.int64),
        mark_kind=marks[:, 1].astype(np.int64),
        mark_source=marks[:, 2].astype(np.int64),
        mark_bearing=np.ascontiguousarray(marks[:, 3]),
        mark_var=np.ascontiguousarray(marks[:, 4]),
        kinds=kinds,
        marks=np.concatenate(places) if places else np.zeros((0, 2)),
        kind_start=np.cumsum([0, *(len(place) for place in places)]).astype(np.int64),
        prior=prior,
        prior_info=info,
        prior_counts=counts,
        notes=tuple(notes),
    )  # fmt: skip


def to_views(
    problem: TeamProblem, views: Sequence[RobotView], owner: np.ndarray
) -> dict[str, np.ndarray]:
    """Return what is said of each bearing, (M,), by robot and in the order of its view."""
    result = {}
    for i, view in enumerate(views):
        ids = np.full(len(view.bearings), NOBODY, dtype=np.int64)
        part = slice(problem.start[i], problem.start[i + 1])
        ids[problem.source[part]] = owner[part]
        result[view.name] = ids
    return result


def _robot_rows(views: Sequence[RobotView], config: TeamConfig, notes: list[str]) -> np.ndarray:
    """Return (robot, bearing, variance, place in the view, known) of each finite bearing."""
    index = {view.name: i for i, view in enumerate(views)}
    parts = []
    for i, view in enumerate(views):
        keep = np.flatnonzero(np.isfinite(view.bearings))
        _note_lost(notes, view.name, len(view.bearings) - len(keep))
        known = [
            (index.get(name, NOBODY) if name else UNKNOWN) if view.known else UNKNOWN
            for name in (view.known or [""] * len(view.bearings))
        ]
        rows = np.empty((len(keep), 5))
        rows[:, 0], rows[:, 1] = i, view.bearings[keep]
        rows[:, 2], rows[:, 3] = _sd(view, config) ** 2, keep
        rows[:, 4] = np.array(known, dtype=float)[keep]
        parts.append(rows)
    return np.concatenate(parts)


def _mark_rows(
    views: Sequence[RobotView], kinds: tuple[str, ...], config: TeamConfig, notes: list[str]
) -> np.ndarray:
    """Return (robot, class, place in the view, bearing, variance) of each landmark seen."""
    parts = [np.zeros((0, 5))]
    for i, view in enumerate(views):
        for kind, bearings in view.landmark_bearings.items():
            if kind not in kinds:
                notes.append(f"{view.name}: nobody knows where {kind} is")
                continue
            keep = np.flatnonzero(np.isfinite(bearings))
            _note_lost(notes, view.name, len(bearings) - len(keep))
            rows = np.empty((len(keep), 5))
            rows[:, 0], rows[:, 1], rows[:, 2] = i, kinds.index(kind), keep
            rows[:, 3], rows[:, 4] = bearings[keep], _sd(view, config) ** 2
            parts.append(rows)
    return np.concatenate(parts)


def _priors(views: Sequence[RobotView]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    prior = np.zeros((len(views), 3))
    info = np.zeros((len(views), 3, 3))
    counts = np.zeros(len(views), dtype=np.bool_)
    for i, view in enumerate(views):
        if view.rough is None or np.max(np.diag(view.rough.cov)) > _FAR**2:
            continue
        prior[i] = view.rough.pose.as_array()
        info[i] = np.linalg.inv(view.rough.cov)
        counts[i] = not (view.rough_from_landmarks and _sees_landmarks(view))
    return prior, info, counts


def _sees_landmarks(view: RobotView) -> bool:
    return any(len(bearings) for bearings in view.landmark_bearings.values())


def _sd(view: RobotView, config: TeamConfig) -> float:
    return config.bearing_sd_rad if view.bearing_sd is None else view.bearing_sd


def _note_lost(notes: list[str], name: str, count: int) -> None:
    if count:
        word = "bearing is" if count == 1 else "bearings are"
        notes.append(f"{name}: {count} {word} not finite and left out")
