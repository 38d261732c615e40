"""A team's views as plain arrays, for the compiled steps.

Bearings of all robots stand behind each other; those of robot i are `start[i]:start[i + 1]`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_views import NOBODY, RobotView

UNKNOWN = -2
"""In `TeamProblem.known`: nobody has said whom this bearing belongs to."""
_NO_YAW = 1e6  # deviation of a yaw that nobody knows, rad


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
        config: For the deviation where a view names none, and which rough poses are none.
    """
    names = tuple(view.name for view in views)
    kinds = tuple(landmarks)
    notes: list[str] = []
    rows, marks = _robot_rows(views, config, notes), _mark_rows(views, kinds, config, notes)
    prior, info, counts = _priors(views, config, notes)
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
    rows: list[tuple[float, ...]] = []
    for i, view in enumerate(views):
        var = _sd(view, config) ** 2
        seen = _finite(view.bearings, view.name, notes)
        for place, bearing in seen:
            name = view.known[place] if view.known else ""
            rows.append((i, bearing, var, place, index.get(name, NOBODY) if name else UNKNOWN))
    return np.array(rows, dtype=float).reshape(-1, 5)


def _mark_rows(
    views: Sequence[RobotView], kinds: tuple[str, ...], config: TeamConfig, notes: list[str]
) -> np.ndarray:
    """Return (robot, class, place in the view, bearing, variance) of each landmark seen."""
    rows: list[tuple[float, ...]] = []
    for i, view in enumerate(views):
        var = _sd(view, config) ** 2
        for kind, bearings in view.landmark_bearings.items():
            if kind not in kinds:
                notes.append(f"{view.name}: nobody knows where {kind} is")
                continue
            at = kinds.index(kind)
            seen = _finite(bearings, view.name, notes)
            rows += [(i, at, place, bearing, var) for place, bearing in seen]
    return np.array(rows, dtype=float).reshape(-1, 5)


def _finite(bearings: np.ndarray, name: str, notes: list[str]) -> list[tuple[int, float]]:
    """Return place and value of each finite bearing, and note the others."""
    values = np.asarray(bearings, dtype=float).tolist()
    seen = [(place, value) for place, value in enumerate(values) if math.isfinite(value)]
    _note_lost(notes, name, len(values) - len(seen))
    return seen


def is_vague(rough: PoseEstimate, config: TeamConfig) -> bool:
    """Return whether a rough pose says so little that it is none."""
    var = rough.cov.diagonal()
    return bool(var[:2].max() > config.far_sd_m**2 or var[2] > _NO_YAW**2)


def _priors(
    views: Sequence[RobotView], config: TeamConfig, notes: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    prior = np.zeros((len(views), 3))
    info = np.zeros((len(views), 3, 3))
    counts = np.zeros(len(views), dtype=np.bool_)
    known = []
    for i, view in enumerate(views):
        if view.rough is None:
            continue
        if is_vague(view.rough, config):
            notes.append(f"{view.name}: its rough pose is too uncertain and left out")
            continue
        pose = view.rough.pose
        prior[i], info[i] = (pose.x, pose.y, pose.yaw), view.rough.cov
        counts[i] = not (view.rough_from_landmarks and _sees_landmarks(view))
        known.append(i)
    if known:
        info[known] = np.linalg.inv(info[known])
    return prior, info, counts


def _sees_landmarks(view: RobotView) -> bool:
    return any(len(bearings) for bearings in view.landmark_bearings.values())


def _sd(view: RobotView, config: TeamConfig) -> float:
    return config.bearing_sd_rad if view.bearing_sd is None else view.bearing_sd


def _note_lost(notes: list[str], name: str, count: int) -> None:
    if count:
        word = "bearing is" if count == 1 else "bearings are"
        notes.append(f"{name}: {count} {word} not finite and left out")
