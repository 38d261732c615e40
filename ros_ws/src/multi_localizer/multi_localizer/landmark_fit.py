"""The most likely pose for bearings and distances of known landmarks, with its covariance.

Beyond the paper: every bearing and distance weighs by its own deviation, a bearing of a wide thing
is that of the end or middle which is seen from where the robot is, and geometry that leaves the
pose open is told and refused.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmarks import Landmark
from multi_localizer.pose_estimate import PoseEstimate

_ROUNDS = 15
_STILL = 1e-9
_SINGULAR = 1e-12
_FLAT = 0.05  # sine between rays of what is taken to be one line
_ON_CIRCLE = 0.15  # off the circle, as a part of its radius
_CURVED = 1.8  # how far the squared deviations may be from what the covariance promises


@dataclass(frozen=True)
class Sighting:
    """One landmark of a class, seen.

    Attributes:
        kind: Its class.
        bearing: In the sensor's frame, rad.
        bearing_sd: Its deviation, rad.
        distance: On the floor, m; NaN if not known.
        distance_sd: Its deviation, m.
    """

    kind: str
    bearing: float
    bearing_sd: float
    distance: float = math.nan
    distance_sd: float = math.nan

    @property
    def num_values(self) -> int:
        """How many numbers it gives."""
        return 1 + math.isfinite(self.distance)


def without_distance(seen: Sighting) -> Sighting:
    """Return a sighting with its bearing alone."""
    return Sighting(seen.kind, seen.bearing, seen.bearing_sd) if seen.num_values > 1 else seen


@dataclass(frozen=True)
class PoseFit:
    """The minimum of the squared deviations.

    Attributes:
        pose: Of the sensor.
        information: Inverse of the covariance, (3, 3).
        chi2: Sum of the squared deviations.
        deviations: Largest deviation of each sighting, (N,), in its own sd.
    """

    pose: SE2
    information: np.ndarray
    chi2: float
    deviations: np.ndarray


def fit_pose(
    start: SE2, sightings: Sequence[Sighting], marks: Sequence[Landmark]
) -> PoseFit | None:
    """Return the most likely pose near a start (Gauss-Newton); None if it runs off.

    Args:
        start: Where to begin.
        sightings: What was seen, (N).
        marks: Which landmark each is, (N).
    """
    pose = start
    for _ in range(_ROUNDS):
        r, J = residuals(pose, sightings, marks)
        H = J.T @ J + _SINGULAR * np.eye(3)
        step = -np.linalg.solve(H, J.T @ r)
        step *= min(1.0, 2.0 / max(float(np.hypot(step[0], step[1])), 1e-12))
        if not np.all(np.isfinite(step)):
            return None
        pose = SE2(pose.x + step[0], pose.y + step[1], pose.yaw + step[2])
        if np.abs(step).max() < _STILL:
            break
    r, J = residuals(pose, sightings, marks)
    own = np.array([k for k, s in enumerate(sightings) for _ in range(s.num_values)])
    off = np.array([np.abs(r[own == k]).max() for k in range(len(sightings))])
    return PoseFit(pose, J.T @ J, float(r @ r), off)


def residuals(
    pose: SE2, sightings: Sequence[Sighting], marks: Sequence[Landmark]
) -> tuple[np.ndarray, np.ndarray]:
    """Return deviations (M,) in their own sd and their derivatives (M, 3) by x, y, yaw."""
    place = np.array([pose.x, pose.y])
    r: list[float] = []
    rows: list[tuple[float, float, float]] = []
    for seen, mark in zip(sightings, marks, strict=True):
        dx, dy = (mark.point_seen(place) - place).tolist()
        d2 = max(dx * dx + dy * dy, 1e-12)
        off = wrap_angle(math.atan2(dy, dx) - pose.yaw - seen.bearing)
        r.append(off / seen.bearing_sd)
        rows.append((dy / d2 / seen.bearing_sd, -dx / d2 / seen.bearing_sd, -1.0 / seen.bearing_sd))
        if seen.num_values == 2:
            d = math.sqrt(d2)
            r.append((d - seen.distance) / seen.distance_sd)
            rows.append((-dx / d / seen.distance_sd, -dy / d / seen.distance_sd, 0.0))
    return np.array(r), np.array(rows)


def estimate_of(fit: PoseFit) -> PoseEstimate | None:
    """Return the pose with its covariance; None if the landmarks leave it open."""
    scale = np.sqrt(np.maximum(np.diag(fit.information), _SINGULAR))
    if np.linalg.eigvalsh(fit.information / np.outer(scale, scale))[0] < 1e-9:
        return None
    return PoseEstimate(fit.pose, np.linalg.inv(fit.information))


def is_curved(
    estimate: PoseEstimate, chi2: float, sightings: Sequence[Sighting], marks: Sequence[Landmark]
) -> bool:
    """Return whether the covariance is no measure: at 2 sd chi2 has not grown by about 4."""
    values, vectors = np.linalg.eigh(estimate.cov)
    step = 2.0 * math.sqrt(values[2]) * vectors[:, 2]
    for x, y, yaw in (step, -step):
        there = SE2(estimate.pose.x + x, estimate.pose.y + y, estimate.pose.yaw + yaw)
        r, _ = residuals(there, sightings, marks)
        if not 4.0 / _CURVED < float(r @ r) - chi2 < 4.0 * _CURVED:
            return True
    return False


def open_geometry(pose: SE2, marks: Sequence[Landmark]) -> str:
    """Return in words what geometry of robot and landmarks leaves the pose badly known."""
    place = np.array([pose.x, pose.y])
    points = np.unique(np.array([mark.point_seen(place) for mark in marks]).round(6), axis=0)
    if len(points) < 3:
        return f"{len(points)} landmarks leave a circle open, not a pose"
    rays = (points - place) / np.maximum(np.hypot(*(points - place).T), 1e-9)[:, None]
    sines = rays[:, None, 0] * rays[None, :, 1] - rays[:, None, 1] * rays[None, :, 0]
    if np.abs(sines).max() < _FLAT:
        return "robot and landmarks lie on one line"
    design = np.column_stack((points, np.ones(len(points))))
    (cx, cy, c), *_ = np.linalg.lstsq(design, (points**2).sum(axis=1), rcond=None)
    center = np.array([cx, cy]) / 2.0
    radius = math.sqrt(max(float(c + center @ center), 0.0))
    corners = np.vstack((points, place))
    if np.abs(np.hypot(*(corners - center).T) - radius).max() < _ON_CIRCLE * radius:
        return "robot and landmarks lie on one circle"
    return "the landmarks are too far away, or too near to each other"
