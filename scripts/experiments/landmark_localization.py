"""Methods 1 and 2 of the team paper for a robot alone, from pictures and from noise of known size.

Pictures: 21 places on the middle-size field, random headings, 160 x 120, the goals' posts as
landmarks. Method 1 takes the bearings of all four, method 2 also where the floor ends below them
(the paper does not say whether of one goal or of both). `as published` weighs all alike;
`likeliest` is the maximum of the likelihood with its covariance, refused where that is no measure.

Noise: bearings of the four posts from the same places with normal errors of one size, beside the
Cramer-Rao bound. The bearings' deviation in pictures is measured at other places with another seed.

Faults: one false bearing among unlike posts, and how often a wrong pose comes out. The paper's
errors are mean absolute ones over 21 places that it does not give.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.stats import chi2

from experiments.landmark_faults import drive_rows, drive_table, fault_rows, fault_table
from experiments.landmark_pictures import draw_errors
from experiments.landmark_report import noise_table, picture_table
from experiments.landmark_views_sim import FieldEye, View, measured_bearing_sd
from floornav_common.arguments import count
from floornav_common.reporting import Picture, Progress, Section
from floornav_common.se2 import SE2
from multi_localizer.landmark_circle import circle_fix
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import Sighting, residuals
from multi_localizer.landmark_floor import floor_fix
from multi_localizer.landmark_locator import LandmarkFix, LandmarkLocator, sightings_of
from multi_localizer.landmark_views import LandmarkViews
from multi_localizer.landmarks import Landmark, Landmarks, load_landmarks, positions
from multi_localizer.pose_estimate import difference, normalized_error

PLACES = [(x, y) for x in np.linspace(-3.3, 3.3, 7) for y in (-1.5, 0.0, 1.5)]
NOISE_DEG = (0.5, 1.0, 2.0, 3.0, 4.0, 6.5)
DRAWS = 10
CALIBRATION_SEED = 1000  # no seed of a run that is quoted
WIDE = {"max_position_sd_m": 2.0, "max_yaw_sd_rad": 1.0}  # noise as large as the paper's must pass
PAPER = {"1": (284.0, 292.0, 15.0), "2": (150.0, 199.0, 3.0)}
POSTS: Landmarks = {
    name: (Landmark((place,)),)
    for name, place in (
        ("goal_yellow_left", (4.11, 0.75)), ("goal_yellow_right", (4.11, -0.75)),
        ("goal_blue_left", (-4.11, -0.75)), ("goal_blue_right", (-4.11, 0.75)),
    )
}  # fmt: skip


@dataclass
class Tally:
    """What one method did."""

    name: str
    paper: tuple[float, float, float] | None = None
    errors: list[np.ndarray] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    bounds: list[np.ndarray] = field(default_factory=list)
    num_refused: int = 0

    def add(self, pose: SE2, found: SE2 | None) -> None:
        """Judge a pose without a covariance."""
        if found is None:
            self.num_refused += 1
        else:
            self.errors.append(difference(found, pose))

    def add_fix(self, pose: SE2, fix: LandmarkFix) -> None:
        """Judge a pose with a covariance."""
        estimate = fix.estimate
        self.add(pose, None if estimate is None else estimate.pose)
        if estimate is not None:
            self.nees.append(normalized_error(estimate.pose, pose, estimate.cov))

    def figures(self) -> dict[str, Any]:
        """Return mean absolute errors, RMS errors, and how true the covariances are."""
        e = np.array(self.errors).reshape(-1, 3) * (1e3, 1e3, 180.0 / math.pi)
        n = len(self.nees)
        return {
            "method": self.name,
            "poses": len(e),
            "refused": self.num_refused,
            **_named("mean", np.abs(e).mean(axis=0) if len(e) else np.full(3, np.nan)),
            **_named("rms", np.sqrt((e**2).mean(axis=0)) if len(e) else np.full(3, np.nan)),
            **_named("paper", np.full(3, np.nan) if self.paper is None else np.array(self.paper)),
            "nees": float(np.mean(self.nees)) if n else None,
            "nees_band": [float(chi2.ppf(q, 3 * n) / n) for q in (0.025, 0.975)] if n else None,
            "crlb_ratio": self._bound_ratio(),
        }

    def _bound_ratio(self) -> float | None:
        """Return the RMS position error over that of the bound."""
        if not self.bounds:
            return None
        own = np.array(self.errors)[:, :2]
        least = np.array([np.trace(b[:2, :2]) for b in self.bounds])
        return float(math.sqrt((own**2).sum(axis=1).mean() / least.mean()))


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    parser.add_argument(
        "--headings", type=count, default=10, metavar="N", help="headings a place (default: 10)"
    )


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Judge both methods on pictures and on bearings with noise."""
    values.update({"places": len(PLACES), "methods": None, "noise": None, "faults": None,
                   "drives": None})  # fmt: skip
    config = replace(LandmarkConfig(), bearing_sd_rad=measured_bearing_sd(CALIBRATION_SEED))
    values["bearing_sd_rad"] = config.bearing_sd_rad
    tallies = _from_pictures(args, config)
    values["methods"] = [tally.figures() for tally in tallies]
    noise = _from_noise(args)
    values["noise"] = noise
    faults = values["faults"] = fault_rows(args.seed, LandmarkConfig())
    drives = values["drives"] = drive_rows(args.seed, LandmarkConfig(), is_quiet=args.quiet)
    path = draw_errors(args.out_dir / "errors.png", tallies[-1].errors, PLACES, args.headings)
    caption = "likeliest, method 2: errors of all headings, twenty times as long"
    return [
        Section(
            "Pictures, 160 x 120, 21 places",
            [picture_table(values["methods"]), Picture(path, caption)],
        ),
        Section("Bearings of four posts with noise", [noise_table(noise)]),
        Section("One of the bearings false by 0.03 to 0.5 rad", [fault_table(faults)]),
        Section("The same in short drives, views confirming each other", [drive_table(drives)]),
    ]


def _from_pictures(args: argparse.Namespace, config: LandmarkConfig) -> list[Tally]:
    tallies = [
        Tally("1, as published", PAPER["1"]), Tally("1, likeliest", PAPER["1"]),
        Tally("2, as published, posts of one goal", PAPER["2"]),
        Tally("2, as published, of both", PAPER["2"]), Tally("2, likeliest", PAPER["2"]),
    ]  # fmt: skip
    rng, eye = np.random.default_rng(args.seed), FieldEye(args.seed)
    field_marks = load_landmarks("middle_size_field")
    by_bearings = LandmarkViews(field_marks, config)
    by_floor = LandmarkViews(field_marks, config, eye.camera)
    points = positions(field_marks)
    with Progress("pictures", len(PLACES) * args.headings, is_quiet=args.quiet) as progress:
        for k, (x, y) in enumerate(np.repeat(PLACES, args.headings, axis=0)):
            pose = SE2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
            view = eye.view(pose, k + 1)
            tallies[0].add(pose, _published_1(view, points))
            tallies[1].add_fix(pose, by_bearings.locate(view.bearings))
            seen = by_floor.sightings(view.bearings, view.mask)
            for goals in (1, 2):
                tallies[1 + goals].add(pose, _published_2(seen, points, goals))
            tallies[4].add_fix(pose, by_floor.locate(view.bearings, view.mask))
            progress.update(k + 1)
    return tallies


def _published_1(view: View, points: dict[str, np.ndarray]) -> SE2 | None:
    seen = [(points[kind][0], b[0]) for kind, b in _known(view, points).items()]
    if len(seen) < 3:
        return None
    return circle_fix(np.array([p for p, _ in seen]), np.array([b for _, b in seen]))


def _published_2(seen: list[Sighting], points: dict[str, np.ndarray], goals: int) -> SE2 | None:
    """Return the pose by the posts of the nearer goal, or of both."""
    far = [s for s in seen if s.kind in points and s.num_values == 2]
    by_goal = [[s for s in far if s.kind.startswith(goal)] for goal in ("goal_yellow", "goal_blue")]
    complete = sorted((g for g in by_goal if len(g) == 2), key=lambda g: g[0].distance)
    posts = [s for goal in complete[:goals] for s in goal]
    if not posts:
        return None
    rays = np.array([(math.cos(s.bearing), math.sin(s.bearing)) for s in posts])
    places = rays * np.array([[s.distance] for s in posts])
    return floor_fix(np.array([points[s.kind][0] for s in posts]), places)


def _known(view: View, points: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {kind: b for kind, b in view.bearings.items() if kind in points and len(b)}


def _from_noise(args: argparse.Namespace) -> list[dict[str, Any]]:
    rows = []
    points = positions(POSTS)
    with Progress("noise", len(NOISE_DEG), is_quiet=args.quiet) as progress:
        for k, noise_deg in enumerate(NOISE_DEG):
            published, likeliest = Tally("1, as published"), Tally("1, likeliest")
            sd = math.radians(noise_deg)
            config = replace(LandmarkConfig(), bearing_sd_rad=sd, **WIDE)
            locator = LandmarkLocator(POSTS, config)
            rng = np.random.default_rng([args.seed, k])
            for x, y in np.repeat(PLACES, DRAWS, axis=0):
                pose = SE2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
                bearings = {
                    kind: _seen(pose, place) + rng.normal(0.0, sd, 1)
                    for kind, place in points.items()
                }
                _judge(pose, bearings, locator, config, published, likeliest)
            rows += [{"noise_deg": noise_deg, **t.figures()} for t in (published, likeliest)]
            progress.update(k + 1)
    return rows


def _judge(
    pose: SE2, bearings: dict[str, np.ndarray], locator: LandmarkLocator, config: LandmarkConfig,
    published: Tally, likeliest: Tally,
) -> None:  # fmt: skip
    sightings = sightings_of(bearings, config)
    bound = _bound(pose, sightings)
    marks = np.array([POSTS[s.kind][0].position for s in sightings])
    found = circle_fix(marks, np.array([s.bearing for s in sightings]))
    published.add(pose, found)
    if found is not None:
        published.bounds.append(bound)
    fix = locator.locate(sightings)
    likeliest.add_fix(pose, fix)
    if fix.estimate is not None:
        likeliest.bounds.append(bound)


def _bound(pose: SE2, sightings: list[Sighting]) -> np.ndarray:
    """Return the least covariance that any unbiased method can have (Cramer-Rao)."""
    _, J = residuals(pose, sightings, [POSTS[s.kind][0] for s in sightings])
    return np.asarray(np.linalg.inv(J.T @ J))


def _seen(pose: SE2, place: np.ndarray) -> np.ndarray:
    local = pose.inverse() @ place
    return np.asarray(np.arctan2(local[:, 1], local[:, 0]))


def _named(what: str, numbers: np.ndarray) -> dict[str, float]:
    names = (f"{what}_x_mm", f"{what}_y_mm", f"{what}_theta_deg")
    return dict(zip(names, (float(v) for v in numbers), strict=True))
