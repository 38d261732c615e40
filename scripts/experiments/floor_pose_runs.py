"""Poses of the floor's shape beside the truth: one estimate after another, and what they amount to.

Of the candidates the one whose yaw is nearer to the truth's counts: which of the two it is, goals
and odometry say, and another experiment tells how well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2

from experiments.floor_pose_bounds import (
    border_pixels,
    bound,
    calibrated,
    calibration_cov,
    noisy_border,
)
from experiments.floor_pose_scenes import Cube, FieldCamera, random_cubes, scene_hiding
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_fit import fit_published
from multi_localizer.floor_fitter import FloorFit, FloorShapeFitter
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_rays import rays_of_pixels
from multi_localizer.pose_estimate import difference
from sim_bridge.appearance import Light
from sim_bridge.camera_config import ImageConfig

POSITIONS_MM = ((0, 0), (600, 0), (1200, 0), (0, 600), (600, 600), (1200, 600))
PAPER = {  # Table 1: RMS of x, y, mm, and theta, deg
    (0, 0): (84, 19, 1.6), (600, 0): (41, 16, 2.6), (1200, 0): (11, 30, 2.2),
    (0, 600): (37, 7, 0.5), (600, 600): (73, 20, 3.3), (1200, 600): (21, 10, 5.2),
}  # fmt: skip
NUM_CUBES = 4
NUM_MATES = 2  # poses that look the same on this field
BORDER_SD_PX = 0.3
MATCHED = {"border_sd_px": BORDER_SD_PX, "offset_sd_px": 0.0, "wall_sd_px": 0.0}
BOUND_CASES = ("true", "calibrated", "true_default", "calibrated_default")
FAILED_M, FAILED_RAD = 0.1, math.radians(5.0)
CONFIDENCE = 0.95


@dataclass(frozen=True)
class View:
    """A picture, its mask and where it was taken."""

    pose: SE2
    picture: np.ndarray
    mask: np.ndarray


@dataclass(frozen=True)
class Outcome:
    """What came of one estimate.

    Attributes:
        error: dx, dy, dyaw of the estimate less the truth, (3,); NaN without one.
        cov: What it said, (3, 3); NaN without one.
        problem: Why there is none.
        is_ambiguous: Whether it said that poses elsewhere fit nearly as well.
    """

    error: np.ndarray
    cov: np.ndarray
    problem: str = ""
    is_ambiguous: bool = False

    @property
    def has_failed(self) -> bool:
        """Whether there is no pose, or one too far off."""
        x, y, yaw = self.error
        return bool(self.problem) or math.hypot(x, y) > FAILED_M or abs(yaw) > FAILED_RAD

    @property
    def nees(self) -> float:
        """The squared error by the covariance said."""
        return float(self.error @ np.linalg.solve(self.cov, self.error))


def judge(fit: FloorFit, truth: SE2) -> Outcome:
    """Return what a fit amounts to; further rivals than the best one's mate do not count."""
    if fit.problem:
        return Outcome(np.full(3, np.nan), np.full((3, 3), np.nan), fit.problem)
    best = min(fit.candidates[:NUM_MATES], key=lambda c: abs(difference(c.pose, truth)[2]))
    return Outcome(
        difference(best.pose, truth), best.cov, is_ambiguous=len(fit.candidates) > NUM_MATES
    )


def judge_published(view: View, camera: FloorCamera, plan: FloorPlan) -> Outcome:
    """Return what the published steps amount to."""
    try:
        poses = fit_published(view.mask, camera, plan)
    except ValueError as error:
        return Outcome(np.full(3, np.nan), np.full((3, 3), np.nan), str(error))
    best = min((difference(p, view.pose) for p in poses), key=lambda e: abs(e[2]))
    return Outcome(best, np.full((3, 3), np.nan))


def rms(outcomes: Iterable[Outcome]) -> np.ndarray:
    """Return the root mean square of the errors of x, y, yaw over those with a pose, (3,)."""
    errors = np.array([o.error for o in outcomes if not o.problem]).reshape(-1, 3)
    return np.asarray(np.sqrt(np.mean(errors**2, axis=0))) if len(errors) else np.full(3, np.nan)


def cell(position: tuple[int, int], outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return a row of Table 1."""
    x, y, yaw = rms(outcomes)
    paper = PAPER[position]
    return {
        "x_mm": position[0], "y_mm": position[1], "rms_x_mm": 1e3 * x, "rms_y_mm": 1e3 * y,
        "rms_theta_deg": math.degrees(yaw), "paper_x_mm": paper[0], "paper_y_mm": paper[1],
        "paper_theta_deg": paper[2], "failures": sum(o.has_failed for o in outcomes),
        "poses": len(outcomes),
    }  # fmt: skip


def consistency(outcomes: Iterable[Outcome]) -> dict[str, Any]:
    """Return the mean NEES with the band it should lie in, and the share within a pose's band."""
    nees = np.array([o.nees for o in outcomes if not o.problem])
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = (float(chi2.ppf(q, 3 * len(nees)) / len(nees)) for q in (tail, 1.0 - tail))
    one = chi2.ppf((tail, 1.0 - tail), 3)
    return {
        "mean": float(nees.mean()), "band": [low, high], "poses": len(nees),
        "share_in_band": float(np.mean((nees >= one[0]) & (nees <= one[1]))),
        "share_below_upper": float(np.mean(nees <= chi2.ppf(CONFIDENCE, 3))),
    }  # fmt: skip


def field_camera(
    size: tuple[int, int],
    seed: int,
    light: Light | None = None,
    image: ImageConfig | None = None,
) -> FieldCamera:
    """Return what takes pictures and masks, the floor's detector with a calibrated camera too."""
    field = FieldCamera(size, light, image, seed)
    rng = np.random.default_rng([seed, 4])
    field.see_through(calibrated(field.camera, rng).camera(field.camera))
    return field


def views_at(
    field: FieldCamera, position: tuple[int, int], num: int, plan: FloorPlan, seed: int
) -> list[View]:
    """Return masks from one position, with headings and cubes drawn anew for each."""
    views = []
    for k in range(num):
        rng = np.random.default_rng([seed, *position, k])
        yaw = float(rng.uniform(-math.pi, math.pi))
        pose = SE2(1e-3 * position[0], 1e-3 * position[1], yaw)
        cubes = tuple(random_cubes(pose, NUM_CUBES, plan, rng))
        views.append(_view(field, pose, cubes, rng))
    return views


def views_hiding(
    field: FieldCamera, share: float, num: int, plan: FloorPlan, seed: int
) -> list[View]:
    """Return masks from anywhere on the field, a share of the border hidden by cubes."""
    views = []
    for k in range(num):
        rng = np.random.default_rng([seed, round(1e3 * share), k])
        pose, cubes = scene_hiding(share, plan, field.camera.height_m, rng)
        views.append(_view(field, pose, cubes, rng))
    return views


def _view(field: FieldCamera, pose: SE2, cubes: tuple[Cube, ...], rng: np.random.Generator) -> View:
    picture = field.picture(pose, cubes, int(rng.integers(1 << 30)))
    return View(pose, picture, field.mask(picture))


def calibrated_fitters(
    camera: FloorCamera, num: int, plan: FloorPlan, seed: int, noise_px: float
) -> list[FloorShapeFitter]:
    """Return fitters, each with a calibration of its own; the first one's paths serve all."""
    rng = np.random.default_rng([seed, 1])
    cameras = [calibrated(camera, rng, noise_px).camera(camera) for _ in range(num)]
    walked = FloorShapeFitter(cameras[0], plan).scanner
    return [FloorShapeFitter(c, plan, scanner=walked.through(c)) for c in cameras]


def border_errors(
    camera: FloorCamera, position: tuple[int, int], num: int, plan: FloorPlan, seed: int
) -> dict[str, Any]:
    """Return errors from border of known noise beside their bound, the mirror known or calibrated.

    Once with a fit that is told what this border is like, of known noise and without offsets, and
    once (`_default`) as it comes, prepared for walls whose border lies off.
    """
    known, S = FloorFitConfig(**MATCHED), calibration_cov(camera)
    true_fit, shipped = FloorShapeFitter(camera, plan, known), FloorShapeFitter(camera, plan)
    outcomes: dict[str, list[Outcome]] = {name: [] for name in BOUND_CASES}
    bounds: dict[str, list[np.ndarray]] = {"true": [], "calibrated": []}
    for k in range(num):
        rng = np.random.default_rng([seed, *position, k, 2])
        pose = SE2(1e-3 * position[0], 1e-3 * position[1], float(rng.uniform(-math.pi, math.pi)))
        cubes = tuple(random_cubes(pose, NUM_CUBES, plan, rng))
        pixels, is_wall = border_pixels(camera, pose, cubes, plan, _num_bearings(camera))
        of_walls = pixels[is_wall & np.isfinite(pixels[:, 0])]
        bounds["true"].append(np.diag(bound(camera, pose, of_walls, plan, BORDER_SD_PX)))
        bounds["calibrated"].append(np.diag(bound(camera, pose, of_walls, plan, BORDER_SD_PX, S)))
        noisy = noisy_border(camera, pixels, BORDER_SD_PX, rng)
        mirror = calibrated(camera, rng).camera(camera)
        fits = {
            "true": true_fit, "calibrated": FloorShapeFitter(mirror, plan, known),
            "true_default": shipped, "calibrated_default": FloorShapeFitter(mirror, plan),
        }  # fmt: skip
        for name, fitter in fits.items():
            outcomes[name].append(
                judge(fitter.fit_border(rays_of_pixels(fitter.camera, noisy)), pose)
            )
    return _ratios(position, outcomes, bounds)


def _ratios(
    position: tuple[int, int],
    outcomes: dict[str, list[Outcome]],
    bounds: dict[str, list[np.ndarray]],
) -> dict[str, Any]:
    """Return RMS errors of each case beside the root mean square of its bounds, as a row."""
    row: dict[str, Any] = {"x_mm": position[0], "y_mm": position[1]}
    for name in outcomes:
        least = np.sqrt(np.mean(bounds[name.removesuffix("_default")], axis=0))
        got = rms(outcomes[name])
        row |= {f"{name}_bound": least.tolist(), f"{name}_rms": got.tolist(),
                f"{name}_ratio": (got / least).tolist(),
                f"{name}_failures": sum(o.has_failed for o in outcomes[name])}  # fmt: skip
    return row


def _num_bearings(camera: FloorCamera) -> int:
    """Return how many pixels the floor's rim is long."""
    return int(2.0 * math.pi * camera.camera.max_radius_px)  # type: ignore[attr-defined]
