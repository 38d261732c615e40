"""All people of a world: those with a plan, the crowd, the recorded ones; and their bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.people.body import body_parts, part_places
from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.obstacles import Obstacles
from sim_bridge.people.recorded import Track, tracks_of
from sim_bridge.people.schema import Crowd, Recording, WalkerPlan
from sim_bridge.people.walkers import Walkers, person_rng
from sim_bridge.people.yielding import Robot
from sim_bridge.solids import Solid

_TRIES = 1000
_SHORTEST_LEG = 1.0
_AWAY = -50.0  # below the floor, apart from each other: where the bodies of absent people are


@dataclass(frozen=True)
class PersonTruth:
    """One person at an instant; for judges only.

    Attributes:
        name: From the world file; `recorded <id>` for a recorded one.
        pose: In the world, x the way they face.
        velocity: In the world, m/s.
        has_noticed: True once they have noticed a robot.
    """

    name: str
    pose: SE2
    velocity: tuple[float, float]
    has_noticed: bool


class People:
    """Everyone in a world, and where their bodies are.

    People live in the coordinates of the world file; what goes in and out is in the world as it
    was moved by `T_world_file`.

    Args:
        config: What people are like.
        plans: Those with a plan.
        crowd: Walkers to draw by seed, or None.
        recording: Recorded people, or None.
        solids: The scenery, in the coordinates of the file.
        T_world_file: How the world was moved.
    """

    def __init__(
        self,
        config: PeopleConfig,
        plans: Sequence[WalkerPlan],
        crowd: Crowd | None,
        recording: Recording | None,
        solids: Sequence[Solid],
        T_world_file: SE2,
    ) -> None:
        self._config, self._plans, self._crowd = config, tuple(plans), crowd
        self._obstacles, self._T = Obstacles(solids), T_world_file
        self._tracks = [] if recording is None else tracks_of(recording)
        num_slots = 1 + max((track.slot for track in self._tracks), default=-1)
        self._num_plans = len(self._plans) + (0 if crowd is None else crowd.num)
        self.num = self._num_plans + num_slots
        self._parts = [body_parts(config, number) for number in range(self.num)]
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Go back to the start; the crowd and everyone's ways are drawn from the seed."""
        crowd = [] if self._crowd is None else drawn_walkers(self._crowd, self._obstacles, seed)
        self._all_plans = [*self._plans, *crowd]
        self._walkers = Walkers(self._config, self._all_plans, self._obstacles, seed)
        self._present: dict[int, tuple[Track, SE2, np.ndarray, float]] = {}
        self._look_up(0.0)

    @property
    def parts(self) -> list[Solid]:
        """The solids of all bodies, person by person, around the origin."""
        return [part for parts in self._parts for part in parts]

    def step(self, stamp_ns: int, dt: float, robots: Sequence[Robot]) -> None:
        """Go on by `dt` from a stamp on; robots are given in the world."""
        if not self.num:
            return
        passers = [(pose.x, pose.y, *velocity) for _, pose, velocity, _ in self._present.values()]
        seen = [_in_file(self._T, robot) for robot in robots]
        self._walkers.step(stamp_ns, dt, seen, np.array(passers).reshape(-1, 4))
        self._look_up(stamp_ns * 1e-9 + dt)

    def places(self) -> np.ndarray:
        """Return where the middle of each of `parts` is on the floor, (parts, 3): x, y, z shift."""
        places = []
        for number, parts in enumerate(self._parts):
            here = self._pose_and_walked(number)
            if here is None:
                places.append(np.array([[2.0 * number, k, _AWAY] for k in range(len(parts))]))
                continue
            flat = self._T @ part_places(self._config, *here)
            places.append(np.column_stack((flat, np.zeros(len(flat)))))
        return np.vstack(places) if places else np.zeros((0, 3))

    def truth(self) -> tuple[PersonTruth, ...]:
        """Return everyone who is there, those with a plan first."""
        people = []
        for number in range(self.num):
            here = self._pose_and_walked(number)
            if here is not None:
                name, velocity, has_noticed = self._who(number)
                c, s = math.cos(self._T.yaw), math.sin(self._T.yaw)
                turned = (
                    float(c * velocity[0] - s * velocity[1]),
                    float(s * velocity[0] + c * velocity[1]),
                )
                people.append(PersonTruth(name, self._T @ here[0], turned, has_noticed))
        return tuple(people)

    def _who(self, number: int) -> tuple[str, np.ndarray, bool]:
        if number < self._num_plans:
            noticed = self._walkers.has_noticed(number)
            return self._all_plans[number].name, self._walkers.velocities[number], noticed
        track, _, velocity, _ = self._present[number - self._num_plans]
        return f"recorded {track.number}", velocity, False

    def _pose_and_walked(self, number: int) -> tuple[SE2, float] | None:
        if number < self._num_plans:
            (x, y), yaw = self._walkers.positions[number], self._walkers.yaws[number]
            return SE2(float(x), float(y), float(yaw)), float(self._walkers.walked[number])
        present = self._present.get(number - self._num_plans)
        return None if present is None else (present[1], present[3])

    def _look_up(self, time: float) -> None:
        """Find who of the recorded people is there, and where."""
        earlier, self._present = self._present, {}
        for track in self._tracks:
            seen = track.at(time)
            if seen is not None:
                position, velocity, walked = seen
                last = earlier.get(track.slot)
                yaw = last[1].yaw if last is not None and last[0] is track else 0.0
                if math.hypot(*velocity) > 0.05:
                    yaw = math.atan2(velocity[1], velocity[0])
                pose = SE2(float(position[0]), float(position[1]), yaw)
                self._present[track.slot] = (track, pose, velocity, walked)


def drawn_walkers(crowd: Crowd, obstacles: Obstacles, seed: int) -> list[WalkerPlan]:
    """Return the walkers of a crowd: to and fro between free places of its rectangle.

    Every leg is free too: the forces push people off a pillar but do not find the way round it.

    Raises:
        ValueError: If no free places are found.
    """
    plans: list[WalkerPlan] = []
    for number in range(crowd.num):
        name = f"walker {number + 1}"
        rng = person_rng(seed, f"ways of {name}")
        others = np.array([plan.path_m[0] for plan in plans]).reshape(-1, 2)
        points = [_free_place(crowd, obstacles, rng, others, None)]
        for _ in range(crowd.num_goals - 1):
            points.append(_free_place(crowd, obstacles, rng, others[:0], points[-1]))
        plans.append(WalkerPlan(name=name, path_m=tuple(points), repeats=True, is_reacting=True))
    return plans


def _free_place(
    crowd: Crowd,
    obstacles: Obstacles,
    rng: np.random.Generator,
    others: np.ndarray,
    last: tuple[float, float] | None,
) -> tuple[float, float]:
    """Draw a place off solids and others (M, 2), in a straight and free line from the last."""
    for _ in range(_TRIES):
        place = rng.uniform(crowd.low_m, crowd.high_m)
        start = place if last is None else np.array(last)
        length = float(np.hypot(*(place - start)))
        way = np.linspace(start, place, 2 + int(length / 0.2))
        is_alone = (np.hypot(*(others - place).T) > 2.0 * crowd.free_m).all()
        is_far = last is None or length > _SHORTEST_LEG
        distance, _ = obstacles.away(way)
        if is_alone and is_far and distance.min(initial=math.inf) >= crowd.free_m:
            return float(place[0]), float(place[1])
    raise ValueError(f"no place free by {crowd.free_m:g} m in the rectangle of the crowd")


def disk_of(
    footprint: Sequence[tuple[float, float]],
    pose: SE2,
    velocity: tuple[float, float],
    laser: tuple[float, float] | None = None,
) -> Robot:
    """Return a robot as people see it.

    Args:
        footprint: Corners in the base frame, m.
        pose: Of the base.
        velocity: Of the base, in the frame of the pose, m/s.
        laser: Where its laser is in the base frame, m; None = it has none.
    """
    corners = np.array(footprint)
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    radius = float(np.linalg.norm(corners - middle, axis=1).max())
    eye = None if laser is None else (pose @ np.array([laser]))[0]
    return Robot((pose @ middle[None])[0], np.array(velocity), radius, eye)


def _in_file(T_world_file: SE2, robot: Robot) -> Robot:
    T = T_world_file.inverse()
    c, s = math.cos(T.yaw), math.sin(T.yaw)
    velocity = np.array([[c, -s], [s, c]]) @ robot.velocity
    eye = None if robot.eye is None else (T @ robot.eye[None])[0]
    return Robot((T @ robot.position[None])[0], velocity, robot.radius, eye)
