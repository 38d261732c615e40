"""Robots that circle among landmarks and see each other, for tests of the team's filter."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.team_filter import TeamFilter
from multi_localizer.team_sightings import Sighting

LANDMARKS = {
    "a": np.array([4.0, 0.5]),
    "b": np.array([-0.5, 4.2]),
    "c": np.array([-3.8, -1.0]),
    "d": np.array([1.2, -4.0]),
}
STEP_NS = 200_000_000
STARTS = {
    "r1": SE2(1.5, 0.0, 1.5),
    "r2": SE2(-1.2, 1.0, -2.4),
    "r3": SE2(0.3, -1.8, 0.4),
}


@dataclass(eq=False)
class World:
    """True poses, and what odometry and cameras say of them.

    Noise is what the filter's configuration means by it; what is left at 0 is exact.
    """

    rng: np.random.Generator
    poses: dict[str, SE2] = field(default_factory=lambda: dict(STARTS))
    travel_noise: float = 0.0
    turn_noise: float = 0.0
    bearing_sd: float = 0.0
    travel_scale: float = 1.0
    turn_scale: float = 1.0
    offset: float = 0.0
    sees: tuple[str, ...] = ("r1", "r2", "r3")
    stamp_ns: int = 0

    def step(self, team: TeamFilter, way: float = 0.08, turn: float = 0.06) -> None:
        """Move every robot by what its odometry says, but for noise and scales."""
        self.stamp_ns += STEP_NS
        for name, pose in self.poses.items():
            told = SE2(way, 0.0, turn)
            along = way * self.travel_scale + self.travel_noise * np.sqrt(way) * self.rng.normal()
            round_ = turn * self.turn_scale
            round_ += self.turn_noise * np.sqrt(abs(turn)) * self.rng.normal()
            self.poses[name] = pose @ SE2(float(along), 0.0, float(round_))
            team.predict(name, told, self.stamp_ns)

    def look(self, team: TeamFilter, name: str, *, is_named: bool = True):
        """Let a robot see all landmarks, if it sees, and all other robots."""
        return team.update(name, self.sightings(name, is_named=is_named), self.stamp_ns)

    def sightings(self, name: str, *, is_named: bool = True) -> list[Sighting]:
        others = tuple(other for other in self.poses if other != name)
        found = []
        if name in self.sees:
            found += [Sighting(self.bearing(name, p), (k,)) for k, p in LANDMARKS.items()]
        for other in others:
            at = np.array([self.poses[other].x, self.poses[other].y])
            found.append(Sighting(self.bearing(name, at), (other,) if is_named else others))
        return found

    def bearing(self, name: str, point: np.ndarray) -> float:
        pose = self.poses[name]
        angle = np.arctan2(point[1] - pose.y, point[0] - pose.x) - pose.yaw + self.offset
        return wrap_angle(float(angle + self.bearing_sd * self.rng.normal()))
