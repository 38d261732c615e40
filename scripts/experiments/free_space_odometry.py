"""The free space that the floor camera sees as the only input of kiss-icp, along a driven route.

A robot drives round the small-size field between its cubes, by a route it knows; its camera's
images become `floor/free_space`, and kiss-icp, as its authors publish it, follows the ends of the
free space as if a laser had seen them. Beside it: wheel odometry, and kiss-icp on the true
distances in the same directions, which is what the field itself allows. Ends of free space lie on
the rings of the template, and rings go along with the robot: coarse ones hold scan matching back,
so that the default template is run beside one with a ring a pixel. Errors are those of the
pose in the frame of the first one; nothing is aligned afterwards.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from experiments.floor_scenes import Scene, cast
from experiments.parallel_tasks import add_spread_options, run_tasks
from floor_perception.config import FloorDetectorConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.resources import load_camera_model
from floornav_common.arguments import count
from floornav_common.reporting import Progress, Section, Table
from floornav_common.se2 import SE2
from sim_bridge.config import RouteConfig
from sim_bridge.route import RouteFollower
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.solids import solids_of
from sim_bridge.world import World, load_world

ROUTE_M = (
    -0.35, -0.10, 0.20, 0.06, 0.85, -0.05, 1.08, 0.20, 0.85, 0.54, 0.30, 0.54, -0.20, 0.40,
    -0.55, 0.02, -0.95, -0.15, -1.05, -0.45, -0.50, -0.52, -0.10, -0.40, -0.15, 0.0, 0.20, 0.10,
    0.85, 0.0,
)  # fmt: skip
SPEED, PERIOD_S, LIMIT_S = 0.3, 0.1, 90.0
SIZE_PX, FINE_RINGS = (640, 480), 144
MAX_RANGE_M, VOXEL_M, FIRST_THRESHOLD_M, MIN_MOTION_M = 2.7, 0.06, 0.1, 0.01
METHODS = (
    "wheel odometry", "kiss-icp on floor/free_space, default", f"the same, {FINE_RINGS} rings",
    "kiss-icp on true distances",
)  # fmt: skip
KEYS = ("odometry", "free_space", "free_space_fine", "ideal")


@dataclass
class Drive:
    """What was seen along a route, image by image.

    Attributes:
        truth: Poses in the world.
        odometry: Wheel odometry's poses, in its own frame.
        seen: Ends of the free space by the default template, (N, 2) each, in the robot's frame.
        fine: The same by the one with a ring a pixel.
        ideal: The true ones in the same directions.
    """

    truth: list[SE2] = field(default_factory=list)
    odometry: list[SE2] = field(default_factory=list)
    seen: list[np.ndarray] = field(default_factory=list)
    fine: list[np.ndarray] = field(default_factory=list)
    ideal: list[np.ndarray] = field(default_factory=list)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--runs", type=count, default=3, metavar="N", help="seeds (default: 3)")
    add_spread_options(parser, jobs=1)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive, follow, measure; fills `values` with the medians over the runs."""
    values.update({key: None for key in (*KEYS, "path_m", "scans", "runs")})
    runs: list[dict[str, Any]] = []
    with Progress("free-space-odometry", args.runs, is_quiet=args.quiet) as progress:
        seeds = range(args.seed, args.seed + args.runs)
        for _, found in run_tasks(_driven, seeds, args.jobs, args.cluster):
            runs.append(found)
            progress.update(len(runs))
    for key in KEYS:
        values[key] = {n: float(np.median([r[key][n] for r in runs])) for n in runs[0][key]}
    values["path_m"] = float(np.median([r["path_m"] for r in runs]))
    values["scans"], values["runs"] = runs[0]["scans"], runs
    rows = [_row(name, values[key]) for name, key in zip(METHODS, KEYS, strict=True)]
    header = ["pose from", "end m", "end % of path", "rms m", "worst m", "end deg"]
    about = f"{args.runs} runs, {values['path_m']:.1f} m, {values['scans']} scans; medians"
    return [Section("Drift", [__doc__ or "", about, Table(header, rows)])]


def _driven(seed: int) -> dict[str, Any]:
    return _measure(drive_route(seed))


def drive_route(seed: int) -> Drive:
    """Drive the route and look around at each image."""
    world = _world()
    simulation = Simulation(world, seed=seed)
    detectors = _detectors()
    (name,) = simulation.models
    follower = RouteFollower(
        RouteConfig(route_m=ROUTE_M, speed_m_s=SPEED, lookahead_m=0.15, max_yaw_rate_rad_s=1.5)
    )
    made, odometry = Drive(), SE2.identity()
    seen = simulation.step({}).robots[name]
    try:
        for _ in range(int(LIMIT_S / (STEP_NS * 1e-9))):
            command = follower.step(seen.ground_truth.pose)
            if command is None:
                return made
            seen = simulation.step({name: command}).robots[name]
            if seen.ground_truth.is_touching:
                raise RuntimeError(f"the robot touched something at {seen.ground_truth.pose}")
            odometry = odometry if seen.odometry is None else seen.odometry.pose
            if seen.omni is not None:
                for points, detector in zip((made.seen, made.fine), detectors, strict=True):
                    points.append(_ends(detector, seen.omni, simulation.stamp_ns))
                made.truth.append(seen.ground_truth.pose)
                made.odometry.append(odometry)
                made.ideal.append(_true_ends(world, seen.ground_truth.pose, detectors[0]))
    finally:
        simulation.close()
    raise RuntimeError(f"the route was not driven within {LIMIT_S:g} s")


def _detectors() -> tuple[FloorDetector, FloorDetector]:
    """Return the default one, and one with a ring a pixel."""
    config, camera = FloorDetectorConfig(), load_camera_model("soccer_small_size")
    fine = replace(config, template=replace(config.template, num_rings=FINE_RINGS))
    return FloorDetector(camera, config), FloorDetector(camera, fine)


def _ends(detector: FloorDetector, image: np.ndarray, stamp_ns: int) -> np.ndarray:
    """Return where the free space of an image ends, (N, 2)."""
    result = detector.detect(image, "rgb", stamp_ns)
    if result is None:
        raise RuntimeError(detector.tracker.reason)
    return result.scan.points()


def _true_ends(world: World, pose: SE2, detector: FloorDetector) -> np.ndarray:
    """Return where the directions of the template first meet something, (N, 2)."""
    template, nothing = detector.template, np.empty(0)
    scene = Scene(pose, tuple(solids_of(world)), nothing, None, nothing)
    bearings = template.bearings
    ranges = cast(scene, bearings, scene.solids)
    is_end = (ranges >= template.edges[0]) & (ranges < template.edges[-1])
    ways = np.stack((np.cos(bearings), np.sin(bearings)), -1)
    return np.asarray((ranges[:, None] * ways)[is_end])


def _world() -> World:
    world = load_world("small_size_field")
    (robot,) = world.robots
    omni = {"period_s": PERIOD_S, "width_px": SIZE_PX[0], "height_px": SIZE_PX[1]}
    return replace(world, robots=(replace(robot, overrides={"omni": omni}),))


def kiss_icp_poses(scans: list[np.ndarray]) -> list[SE2]:
    """Return kiss-icp's poses in the frame of the first scan."""
    from kiss_icp.config import KISSConfig
    from kiss_icp.kiss_icp import KissICP

    config = KISSConfig()
    config.data.deskew, config.data.max_range = False, MAX_RANGE_M
    config.mapping.voxel_size = VOXEL_M
    config.adaptive_threshold.initial_threshold = FIRST_THRESHOLD_M
    config.adaptive_threshold.min_motion_th = MIN_MOTION_M
    config.registration.max_num_threads = 1
    odometry, poses = KissICP(config), []
    for points in scans:
        odometry.register_frame(np.pad(points, ((0, 0), (0, 1))), np.empty(0))
        T = odometry.last_pose
        poses.append(SE2(T[0, 3], T[1, 3], math.atan2(T[1, 0], T[0, 0])))
    return poses


def _measure(drive: Drive) -> dict[str, Any]:
    scans = (drive.seen, drive.fine, drive.ideal)
    poses = (drive.odometry, *(kiss_icp_poses(s) for s in scans))
    steps = zip(drive.truth, drive.truth[1:], strict=False)
    path = sum(a.between(b).distance for a, b in steps)
    errors = {k: drift(p, drive.truth, path) for k, p in zip(KEYS, poses, strict=True)}
    return {**errors, "path_m": path, "scans": len(drive.truth)}


def drift(poses: list[SE2], truth: list[SE2], path: float) -> dict[str, float]:
    """Return how far poses come to be off, both seen from their first."""
    off = [
        truth[0].between(t).between(poses[0].between(p)) for t, p in zip(truth, poses, strict=True)
    ]
    distances = np.array([o.distance for o in off])
    return {
        "end_m": float(distances[-1]),
        "end_share": float(distances[-1] / path),
        "rms_m": float(np.sqrt(np.mean(distances**2))),
        "worst_m": float(distances.max()),
        "end_deg": abs(math.degrees(off[-1].yaw)),
    }


def _row(name: str, f: dict[str, float]) -> list[str]:
    share = f"{100.0 * f['end_share']:.2f}"
    return [name, f"{f['end_m']:.3f}", share, f"{f['rms_m']:.3f}", f"{f['worst_m']:.3f}",
            f"{f['end_deg']:.1f}"]  # fmt: skip
