"""How much faster than real time worlds run, by sensor set, and what a sensor's frame costs.

A set's figure is the time of a step with a frame over that of the steps without one; its peer is
the bare pybullet call with the same rays or pixels in the same world (`rayTestBatch`,
`getCameraImage` with its TINY renderer; a mirror's image counts as one flat image of its size).
Real-time factors are of the core, `Simulation.step`, without DDS and the node around it.
To reach: 10 x real time with laser and 16 sonars, 1 x with everything on at 10 Hz; each such row
says whether it was.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from experiments.timing import Case
from sim_bridge.drive import Velocity
from sim_bridge.laser import beam_directions
from sim_bridge.rays import BEYOND
from sim_bridge.schema import WorldError
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.sonar import cone_rays
from sim_bridge.world import RobotPlacement, World, load_world

SIM_S = 10.0
NUM_PEER_CALLS = 15
_DRIVE = Velocity(0.1, 0.3)
_NO_SONAR = {"sonar": None}
_LARGE_OMNI = {"omni": {"width_px": 640, "height_px": 480}}


@dataclass(frozen=True)
class SensorSet:
    """One row.

    Attributes:
        name: Of the case.
        world: Of the package.
        overrides: Of every robot.
        frame: Which observation is timed.
        guests: Robots that come in beside the world's own.
        num_threads: Threads that draw images.
        to_reach: Real-time factor that is asked for; None = none is.
    """

    name: str
    world: str
    overrides: Mapping[str, Any]
    frame: str
    guests: tuple[RobotPlacement, ...] = ()
    num_threads: int = 1
    to_reach: float | None = None


# One robot with laser and stereo, one with a mirror, one with laser and 16 sonars.
_GUESTS = (
    RobotPlacement(model="soccer_small_size", name="mirror", position_m=(1.0, 1.0)),
    RobotPlacement(model="segway_rmp50", name="sonars", position_m=(1.6, 4.3)),
)
SETS = (
    SensorSet("laser", "furnished_floor", _NO_SONAR, "scan"),
    SensorSet("laser_16_sonars", "furnished_floor", {}, "sonar", to_reach=10.0),
    SensorSet("omni_256x220", "small_size_field", {}, "omni"),
    SensorSet("omni_640x480", "small_size_field", _LARGE_OMNI, "omni"),
    SensorSet("two_stereo_pairs_320x240", "stereo_room", {"laser": None, **_NO_SONAR}, "stereo"),
    SensorSet("8_robots_with_laser", "fleet", _NO_SONAR, "scan"),
    SensorSet("everything", "stereo_room", {}, "stereo", _GUESTS, to_reach=1.0),
    SensorSet("everything_2_threads", "stereo_room", {}, "stereo", _GUESTS, 2, to_reach=1.0),
)


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return the cases."""
    cases = []
    for row in SETS:
        say(f"simulation: {row.name}, {SIM_S:.0f} simulated seconds")
        cases.append(_case(row, seed))
    return cases


def _case(row: SensorSet, seed: int) -> Case:
    try:
        simulation = Simulation(_world_of(row), seed=seed, num_threads=row.num_threads)
    except WorldError as error:
        return Case(row.name, np.nan, np.nan, extra={"real_time_factor": None, "why": str(error)})
    try:
        ms, has_frame, cpu_s = _step_times(simulation, row.frame)
        peer, peer_ms = _peer(simulation, row.frame)
    finally:
        simulation.close()
    if not has_frame.any():
        why = f"no {row.frame} in this world"
        return Case(row.name, np.nan, np.nan, extra={"real_time_factor": None, "why": why})
    idle = float(np.median(ms[~has_frame]))
    frames = ms[has_frame] - idle
    factor = float(len(ms) * STEP_NS * 1e-6 / ms.sum())
    extra = {
        "real_time_factor": factor,
        **_verdict(factor, row.to_reach),
        "simulated_s_per_cpu_s": len(ms) * STEP_NS * 1e-9 / cpu_s,
        "step_without_frame_ms": idle,
        "frames": int(has_frame.sum()),
        "robots": len(simulation.models),
    }
    median, p99 = float(np.median(frames)), float(np.percentile(frames, 99))
    return Case(row.name, median, p99, peer, peer_ms, None, extra)


def _verdict(factor: float, to_reach: float | None) -> dict[str, Any]:
    if to_reach is None:
        return {}
    return {"to_reach": to_reach, "reached": "yes" if factor >= to_reach else "no"}


def _world_of(row: SensorSet) -> World:
    world = load_world(row.world)
    robots = tuple(replace(r, overrides={**r.overrides, **row.overrides}) for r in world.robots)
    if row.guests:
        robots = tuple(replace(r, name=r.name or "host") for r in robots)
    return replace(world, robots=(*robots, *row.guests))


def _step_times(simulation: Simulation, frame: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the time of each step, ms, whether any robot gave the frame in it, and all CPU s.

    The last, over all threads, suffers less from what else the machine does.
    """
    commands = dict.fromkeys(simulation.models, _DRIVE)
    for _ in range(30):
        simulation.step(commands)
    ms, has_frame, cpu_s = [], [], time.process_time()
    for _ in range(round(SIM_S * 1e9 / STEP_NS)):
        started = time.perf_counter()
        seen = simulation.step(commands)
        ms.append(1e3 * (time.perf_counter() - started))
        has_frame.append(any(getattr(r, frame) is not None for r in seen.robots.values()))
    return np.array(ms), np.array(has_frame), time.process_time() - cpu_s


def _peer(simulation: Simulation, frame: str) -> tuple[str, float]:
    """Return name and median time, ms, of the bare engine call for one frame of every robot."""
    physics = simulation._physics  # noqa: SLF001, the engine itself is what we are held against
    engine, client = physics._engine, physics._client
    call, what = _bare_call(simulation, frame, engine, client)
    times = []
    for _ in range(NUM_PEER_CALLS):
        started = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - started))
    return what, float(np.median(times))


def _bare_call(
    simulation: Simulation, frame: str, engine: Any, client: int
) -> tuple[Callable[[], object], str]:
    configs = [model.config for model in simulation.models.values()]
    if frame in ("scan", "sonar"):
        batches = [_rays(simulation, name, frame) for name in simulation.models]

        def cast() -> None:
            for starts, ends in batches:
                engine.rayTestBatch(starts, ends, physicsClientId=client)

        return cast, "pybullet rayTestBatch"
    sizes = [(c.omni.width_px, c.omni.height_px) for c in configs if frame == "omni" and c.omni]
    sizes += [
        (c.stereo.width_px, c.stereo.height_px)
        for c in configs
        if frame == "stereo" and c.stereo
        for _ in c.stereo.frames
    ]
    start = next(iter(simulation.starts.values()))
    eye, target = [start.x, start.y, 0.3], [start.x + 1.0, start.y, 0.2]
    view = engine.computeViewMatrix(eye, target, [0.0, 0.0, 1.0])

    def draw() -> None:
        for width, height in sizes:
            lens = engine.computeProjectionMatrixFOV(60.0, width / height, 0.05, 20.0)
            engine.getCameraImage(
                width, height, view, lens, renderer=engine.ER_TINY_RENDERER, physicsClientId=client
            )

    return draw, f"pybullet getCameraImage x {len(sizes)}"


def _rays(
    simulation: Simulation, name: str, frame: str
) -> tuple[list[list[float]], list[list[float]]]:
    """Return the rays of a scan, or those that the sonars of one slot send out, as lists.

    What sonars follow besides, the ways that sound takes after its first wall, is only ours.
    """
    config, start = simulation.models[name].config, simulation.starts[name]
    if frame == "scan" and config.laser is not None:
        ends = config.laser.range_max_m * beam_directions(config.laser)
        origin = [start.x, start.y, 0.36]
        return [origin] * len(ends), (ends + origin).tolist()
    assert config.sonar is not None
    T_world_base, cone = np.eye(4), BEYOND * config.sonar.range_max_m * cone_rays(config.sonar)
    c, s = np.cos(start.yaw), np.sin(start.yaw)
    T_world_base[:2, :2], T_world_base[:2, 3] = [[c, -s], [s, c]], [start.x, start.y]
    mounts = simulation.models[name].mounts
    frames = [f"{config.sonar.frame}{k}" for k in config.sonar.firing_order[0]]
    poses = [T_world_base @ mounts[frame] for frame in frames]
    starts = np.repeat([T[:3, 3] for T in poses], len(cone), axis=0)
    return starts.tolist(), (starts + np.vstack([cone @ T[:3, :3].T for T in poses])).tolist()
