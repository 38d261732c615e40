"""Drives for `slam`: generated office floors, twice round, past glass and people, wheels that slip.

Taken are the generator's floors with two corridors that are joined at both ends, so that the robot
comes back to where it was by another way. Its route is driven twice. In each corridor two people
walk to and fro and step aside for each other and for the robot, as far as they notice it; the robot
waits for who stands right before it. Wheels and laser are worse than the robot file's (`ROBOT`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import count, islice
from pathlib import Path

import numpy as np

from experiments.glass_drive import drive_world
from experiments.glass_logs import GlassLog, load_log
from sim_bridge.people.schema import WalkerPlan
from sim_bridge.world import Route, World, load_world

FIRST_FLOOR = 7500
"""Floors of the experiment. Values were set on others (`corridor_loop`, 200 and on), and what makes
a loop certain was worked out on floors 7003 to 7027."""
SHARES = (0.2, 0.3, 0.4, 0.5)
LAPS = 2
SPEED_M_S = 0.9
PATIENCE_S = 5.0
"""Two who wait for each other in a corridor would wait for good: the robot goes first."""
ROBOT = {
    "wheels": {"radius_error_sd": 0.003, "slip_mean": 0.01, "slip_sd": 0.02},
    "laser": {
        "num_beams": 341, "fov_rad": math.radians(240.0), "period_s": 0.2, "range_max_m": 4.0,
        "noise_sd_m": 0.01, "noise_sd_share": 0.01,
    },
}  # fmt: skip
"""Wheels twice as bad as the robot file's; a laser like the URG-04LX, to 4 m."""
_LONGEST_S = 3600.0
_TWO_CORRIDORS_M = 14.2  # one corridor and two rows of rooms are less deep, two and three deeper
_PEOPLE_A_CORRIDOR = 2
_BESIDE_M = 0.45
_FROM_END_M = 2.5


def floor_names(num: int, seed: int = 0) -> list[str]:
    """Return the names of the first floors with a ring of corridors, glass shares in turn."""
    rings = (k for k in count(FIRST_FLOOR + 1000 * seed) if _has_ring(f"generated:{k}:0"))
    return [f"generated:{k}:{SHARES[i % len(SHARES)]:g}" for i, k in enumerate(islice(rings, num))]


def peopled(world: World, seed: int) -> World:
    """Return a floor with people in its corridors, its route driven twice, on worse wheels."""
    assert world.route is not None
    (robot,) = world.robots
    rng = np.random.default_rng((seed, 17))
    return replace(
        world,
        people=tuple(_walkers(world, rng)),
        robots=(replace(robot, overrides={**robot.overrides, **ROBOT}),),
        route=Route(waypoints_m=LAPS * world.route.waypoints_m, speed_m_s=SPEED_M_S),
    )


def drive_floor(name: str, seed: int, cache: Path | None = None) -> GlassLog:
    """Return the log of the drive on one floor.

    Args:
        name: As `floor_names` has it.
        seed: Of people, wheels and sensors.
        cache: Folder of logs; one that is there is not driven again.
    """
    path = None if cache is None else cache / f"slam-{name.replace(':', '-')}-{seed}.npz"
    log = None if path is None else load_log(path)
    if log is None:
        world = peopled(load_world(name), seed)
        taken = drive_world(world, seed, SPEED_M_S, _LONGEST_S, PATIENCE_S)
        log = GlassLog(world=name, seed=seed, **taken)
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            log.save(path)
    return log


def _has_ring(name: str) -> bool:
    return max(wall.to_m[1] for wall in load_world(name).walls) > _TWO_CORRIDORS_M


def _walkers(world: World, rng: np.random.Generator) -> Iterator[WalkerPlan]:
    """Yield people who walk to and fro along the corridors, beside their middle."""
    assert world.route is not None
    width = max(wall.to_m[0] for wall in world.walls)
    for y in _corridors(world):
        for k in range(_PEOPLE_A_CORRIDOR):
            side = _BESIDE_M * (1 if k % 2 else -1)
            ends = [(_FROM_END_M, y + side), (width - _FROM_END_M, y + side)]
            ends = ends if rng.random() < 0.5 else ends[::-1]
            yield WalkerPlan(
                name=f"walker {y:.1f} {k}", path_m=tuple(ends), repeats=True, is_reacting=True,
                starts_s=float(rng.uniform(0.0, 40.0)), pauses_s=(0.0, float(rng.uniform(0, 20))),
            )  # fmt: skip


def _corridors(world: World) -> list[float]:
    """Return the middle lines of the two corridors: the route crosses between them at one x."""
    assert world.route is not None
    pairs = zip(world.route.waypoints_m, world.route.waypoints_m[1:], strict=False)
    (longest,) = sorted((math.dist(a, b) * (a[0] == b[0]), a[1], b[1]) for a, b in pairs)[-1:]
    return sorted(longest[1:])
