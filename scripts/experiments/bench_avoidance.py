"""Time of one avoidance step, from a scan to a command, beside the same step in plain numpy.

Scenes: places on the small-size field with cubes, seen in 180 or 541 directions, at random
velocities; where nothing near the goal is open, slower speeds are tried too, and that is in the
times. The peer predicts the ways of one speed with numpy (eq. 12 to 15, no growing, no guard).
Floor: one numpy arctan2 over all places of those ways.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from experiments.avoidance_fields import CUBE, ROBOT_RADIUS, random_field
from experiments.corridor_loop import ray_cast
from experiments.timing import Case, median_and_p99, take_turns
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.limited_motion import limited_position
from sjmc_planner.methods import make_method
from sjmc_planner.omni_velocity import directions
from sjmc_planner.planning import Goal, Obstacles, RobotState, Velocity

NUM_SCENES, NUM_TURNS = 60, 5
HALF_X, HALF_Y = 1.37, 0.7625
_KINDS = {"180 directions, omni": (180, "omni"), "541 directions, omni": (541, "omni"),
          "180 directions, differential": (180, "differential")}  # fmt: skip
Scene = tuple[RobotState, Obstacles, Goal]


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each kind of scan and robot."""
    cases = []
    for name, (num_beams, drive) in _KINDS.items():
        say(f"avoidance: {name}")
        scenes = [_scene(seed, k, num_beams, drive) for k in range(NUM_SCENES)]
        method = make_method(LocalPlannerConfig(robot=RobotConfig(drive=drive)))
        ms: dict[str, list[np.ndarray]] = {}
        for state, obstacles, goal in scenes:
            calls = {
                "step": partial(method.decide, state, obstacles, goal),
                "peer": partial(_plain_step, state, obstacles),
                "floor": partial(np.arctan2, *_WAYS),
            }
            for key, values in take_turns(calls, NUM_TURNS).items():
                ms.setdefault(key, []).append(values)
        median, p99 = median_and_p99(np.concatenate(ms["step"]))
        peer, floor = (float(np.median(np.concatenate(ms[key]))) for key in ("peer", "floor"))
        cases.append(Case(name, median, p99, "the ways in plain numpy", peer, floor))
    return cases


def _scene(seed: int, number: int, num_beams: int, drive: str) -> Scene:
    rng = np.random.default_rng([seed, number])
    field = random_field(seed, number)
    while True:
        x, y = rng.uniform((-1.1, -0.55), (1.1, 0.55))
        if np.hypot(*(field.cubes[:, :2] - (x, y)).T).min() > 2.0 * ROBOT_RADIUS + CUBE:
            break
    yaw, speed, aside = rng.uniform((-math.pi, 0.0, -0.1), (math.pi, 0.35, 0.1))
    step = 2.0 * math.pi / num_beams
    angles = -math.pi + step * np.arange(num_beams)
    ranges = ray_cast(np.array([x, y]), angles + yaw, _walls(field.cubes))
    scan = Scan(ranges, -math.pi, step, 0.17, 2.5)
    goal = (SE2(x, y, yaw).inverse() @ np.array([field.goal]))[0]
    velocity = Velocity(speed, aside if drive == "omni" else 0.0, 0.0)
    return RobotState(velocity), Obstacles(scan, SE2.identity()), Goal(goal, math.hypot(*goal))


def _walls(cubes: np.ndarray) -> np.ndarray:
    """Return the field's border and the cubes' sides as segments, (N, 4)."""
    border = np.array([[-HALF_X, -HALF_Y], [HALF_X, -HALF_Y], [HALF_X, HALF_Y], [-HALF_X, HALF_Y]])
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * CUBE / 2.0
    outlines = [border, *(SE2(*cube) @ square for cube in cubes)]
    return np.concatenate([np.hstack((o, np.roll(o, -1, axis=0))) for o in outlines])


def _plain_step(state: RobotState, obstacles: Obstacles) -> np.ndarray:
    """Return T_j by whole arrays, with the table of obstacles taken as it comes."""
    va = np.array([state.velocity.x, state.velocity.y])
    ways = limited_position(va, _TARGETS, 0.3, 0.03, _TIMES)
    r, phi = np.hypot(ways[..., 0], ways[..., 1]), np.arctan2(ways[..., 1], ways[..., 0])
    ranges = obstacles.scan.ranges
    entry = np.rint((phi + np.pi) * len(ranges) / (2.0 * np.pi)).astype(int) % len(ranges)
    is_hit = r >= ranges[entry]
    return np.where(is_hit.any(axis=1), _TIMES[is_hit.argmax(axis=1)], np.inf)


_BEARINGS = directions(180)
_TARGETS = 0.4 * np.column_stack((np.cos(_BEARINGS), np.sin(_BEARINGS)))
_TIMES = np.arange(0.0, 2.751, 0.05)
_WAYS = tuple(
    limited_position(np.array([0.4, 0.0]), _TARGETS, 0.3, 0.03, _TIMES).reshape(-1, 2).T.copy()
)
