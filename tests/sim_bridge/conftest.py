"""Small worlds, and robots without noise."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from floornav_common.se2 import SE2
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, Wall, World

PERFECT: dict[str, Any] = {
    "drive": {"command_delay_s": 0.0},
    "wheels": {"ticks_per_turn": 0, "radius_error_sd": 0.0, "slip_mean": 0.0, "slip_sd": 0.0},
    "laser": {
        "noise_sd_m": 0.0, "noise_sd_share": 0.0, "quantum_m": 0.0, "dropout_share": 0.0,
        "edge_share": 0.0,
    },
}  # fmt: skip


def box_room(overrides: dict[str, Any] | None = None, pose: SE2 | None = None) -> World:
    """Return a room whose inner faces are at x = 0 and 6, y = 0 and 4 m; robot at (2, 1)."""
    corners = ((-0.05, -0.05), (6.05, -0.05), (6.05, 4.05), (-0.05, 4.05))
    walls = tuple(
        Wall(from_m=a, to_m=b, thickness_m=0.1)
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)
    )
    pose = SE2(2.0, 1.0, 0.0) if pose is None else pose
    robot = RobotPlacement(
        model="segway_rmp50",
        position_m=(pose.x, pose.y),
        yaw_deg=pose.yaw * 57.29577951308232,
        overrides={} if overrides is None else overrides,
    )
    return World(name="box_room", walls=walls, robots=(robot,))


@pytest.fixture
def simulate() -> Iterator[Callable[..., Simulation]]:
    """Return a function that makes a simulation and frees it after the test."""
    made: list[Simulation] = []

    def make(world: World, **options: Any) -> Simulation:
        made.append(Simulation(world, **options))
        return made[-1]

    yield make
    for simulation in made:
        simulation.close()
