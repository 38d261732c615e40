"""Everyone with a plan: scripted walkers, and those who heed walls, people and robots."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import wrap_angle
from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.forces import kept_apart, push_between, push_of_walls, seen_share
from sim_bridge.people.obstacles import Obstacles
from sim_bridge.people.plan_progress import PlanProgress
from sim_bridge.people.schema import WalkerPlan
from sim_bridge.people.yielding import (
    Robot,
    Traits,
    attention_after,
    draw_traits,
    held_back,
    side_step,
)

_DECISION_NS = 50_000_000
_TURN_RATE = 4.0
_FASTEST = 1.3  # times the wanted speed, Helbing and Molnar (1995)


def person_rng(seed: int, name: str) -> np.random.Generator:
    """Return the stream of one person, so that adding another changes nobody."""
    return np.random.default_rng(
        np.random.SeedSequence([seed, zlib.crc32(f"person {name}".encode())])
    )


class Walkers:
    """Where everyone with a plan is; the main method is `step`.

    Args:
        config: What people are like.
        plans: Who goes where.
        obstacles: The scenery.
        seed: Seed of who they are.

    Attributes:
        positions: Shape (N, 2), m.
        velocities: Shape (N, 2), m/s.
        yaws: Shape (N,), rad.
        walked: Distance walked so far, shape (N,), m.
    """

    def __init__(
        self,
        config: PeopleConfig,
        plans: Sequence[WalkerPlan],
        obstacles: Obstacles,
        seed: int,
    ) -> None:
        self._config, self._plans, self._obstacles = config, list(plans), obstacles
        self.traits = [_traits(config, plan, seed) for plan in plans]
        self._progress = [
            PlanProgress(plan, traits.speed, config.torso_radius_m)
            for plan, traits in zip(self._plans, self.traits, strict=True)
        ]
        starts = [plan.path_m[0] for plan in self._plans]
        self.positions = np.array(starts, dtype=float).reshape(-1, 2)
        self.velocities = np.zeros_like(self.positions)
        self.yaws = np.array([progress.first_yaw() for progress in self._progress])
        self.walked = np.zeros(len(self._plans))
        self._reacting = [k for k, plan in enumerate(self._plans) if plan.is_reacting]
        self._attention: dict[tuple[int, int], float] = {}
        self._side: dict[tuple[int, int], int] = {}

    def has_noticed(self, k: int) -> bool:
        """Tell whether a person has noticed any robot."""
        return any(value >= 1.0 for (who, _), value in self._attention.items() if who == k)

    def step(self, stamp_ns: int, dt: float, robots: Sequence[Robot], passers: np.ndarray) -> None:
        """Go on by one step.

        Args:
            stamp_ns: Simulated time at its start.
            dt: Its length, s.
            robots: Where the robots are.
            passers: Position and velocity of people without a plan, shape (M, 4).
        """
        for k, progress in enumerate(self._progress):
            progress.look(stamp_ns * 1e-9, self.positions[k], robots, dt)
        if self._reacting and stamp_ns % _DECISION_NS == 0:
            self._decide(robots, passers)
        before = self.positions.copy()
        for k, progress in enumerate(self._progress):
            if not self._plans[k].is_reacting:
                self.positions[k], self.velocities[k] = progress.advance(before[k], dt)
        self.positions[self._reacting] += dt * self.velocities[self._reacting]
        if self._reacting:
            others = np.vstack((self.positions, passers[:, :2]))
            least = 2.0 * self._config.torso_radius_m
            moved = kept_apart(self.positions[self._reacting], others, least)
            self.positions[self._reacting] = moved
        self.walked += np.hypot(*(self.positions - before).T)
        self._turn(dt)

    def _decide(self, robots: Sequence[Robot], passers: np.ndarray) -> None:
        """Choose the velocities of those who react, for one decision period."""
        config, who, dt = self._config, self._reacting, _DECISION_NS * 1e-9
        now, speed = self.positions[who], self.velocities[who]
        wanted = np.array([self._progress[k].wanted(self.positions[k]) for k in who])
        length = np.hypot(*wanted.T)
        direction = wanted / np.maximum(length, 1e-9)[:, None]
        push = push_between(
            config, now,
            np.vstack((self.positions, passers[:, :2])),
            np.vstack((self.velocities, passers[:, 2:])),
        )  # fmt: skip
        push = seen_share(config, push, direction).sum(axis=1)
        push += push_of_walls(config, now, self._obstacles)
        wanted = np.array([self._making_room(k, wanted[n], robots) for n, k in enumerate(who)])
        after = speed + dt * ((wanted - speed) / config.relaxation_s + push)
        fastest = _FASTEST * np.array([self.traits[k].speed for k in who])
        over = np.hypot(*after.T) / fastest
        after /= np.maximum(over, 1.0)[:, None]
        for n, k in enumerate(who):
            self.velocities[k] = self._kept_off(k, after[n], robots)

    def _making_room(self, k: int, wanted: np.ndarray, robots: Sequence[Robot]) -> np.ndarray:
        """Notice robots and return the wanted velocity with room made for them, (2,)."""
        going = wanted if self._progress[k].is_under_way() else np.zeros(2)
        for number, robot in enumerate(robots):
            key = (k, number)
            self._attention[key] = self._notice(k, key, robot)
            if self._attention[key] >= 1.0:
                side, traits = self._side.get(key, 0), self.traits[k]
                aside = side_step(self._config, traits, self.positions[k], going, robot, side)
                self._side[key] = aside.side
                # Nobody walks back into the way while the robot passes.
                back = min(float(wanted @ aside.direction), 0.0)
                wanted = wanted + (aside.speed - back) * aside.direction
        return wanted

    def _notice(self, k: int, key: tuple[int, int], robot: Robot) -> float:
        old = self._attention.get(key, 0.0)
        off = robot.position - self.positions[k]
        distance = float(np.hypot(*off))
        if old >= 1.0 or distance > self.traits[k].notice_distance:
            return old if old >= 1.0 else 0.0
        if self._obstacles.is_hidden(self.positions[k], robot.position):
            distance = math.inf
        bearing = wrap_angle(math.atan2(off[1], off[0]) - self.yaws[k])
        dt = _DECISION_NS * 1e-9
        return attention_after(self._config, self.traits[k], old, bearing, distance, dt)

    def _kept_off(self, k: int, velocity: np.ndarray, robots: Sequence[Robot]) -> np.ndarray:
        for number, robot in enumerate(robots):
            if self._attention.get((k, number), 0.0) >= 1.0:
                velocity = held_back(self._config, self.positions[k], velocity, robot)
        return velocity

    def _turn(self, dt: float) -> None:
        for k, (vx, vy) in enumerate(self.velocities.tolist()):
            if math.hypot(vx, vy) > 0.2:
                turn = wrap_angle(math.atan2(vy, vx) - self.yaws[k])
                self.yaws[k] += max(-_TURN_RATE * dt, min(_TURN_RATE * dt, turn))


def _traits(config: PeopleConfig, plan: WalkerPlan, seed: int) -> Traits:
    if plan.never_notices is not None:
        config = replace(config, never_share=1.0 if plan.never_notices else 0.0)
    drawn = draw_traits(config, person_rng(seed, plan.name))
    return replace(drawn, speed=plan.speed_m_s) if plan.speed_m_s > 0.0 else drawn
