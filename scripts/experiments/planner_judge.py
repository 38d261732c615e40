"""What is measured of a drive among people, by the truth of the simulation.

Distances to people are from the robot's outline to the circle of the torso. A contact is the
engine's (legs that step out included) or an outline that reaches the torso; one with a person is
the robot's own doing if it moves faster than 0.05 m/s and the person is in its front half-plane,
ahead of the outline's middle, also while it backs away; or if it moves into them: the point of the
outline next to them goes towards them faster than that, backing and turning on the spot included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from experiments.planner_contacts import MOVING, gap_to, is_by_robot
from floornav_common.se2 import SE2
from sim_bridge.observations import Observations
from sim_bridge.people.people import PersonTruth
from sim_bridge.robot_model import RobotModel
from sim_bridge.simulation import Simulation
from sjmc_planner.planning import Decision

TURN_RAD = math.radians(15.0)
_LEG_REACH = 0.3  # of a leg beyond the torso, with some air, m
_CONTACT_S = 1.0  # touching the same again within this is the same contact
_TRACK_EVERY = 10  # steps between two kept places of people


@dataclass(frozen=True)
class Contact:
    """One touch.

    Attributes:
        time_s: When.
        name: Of the person; "" for a thing.
        by_robot: Whether the robot did it.
    """

    time_s: float
    name: str
    by_robot: bool


@dataclass(frozen=True)
class Drive:
    """What came of a drive.

    Attributes:
        is_reached: Whether it came to its goal or was over.
        time_s: How long it took.
        times: Of each step, shape (N,), s.
        poses: x, y, yaw of base_link in the world, shape (N, 3).
        speeds: Over the floor, shape (N,), m/s.
        off_goal: Angle from where the robot faces to the goal, shape (N,), rad.
        gaps: Least distance to a torso, shape (N,), m; inf with nobody there.
        contacts: In order.
        states: Time and state of each change of the method's state: (s, state, reason).
        people: Places of everyone by name: rows t, x, y.
    """

    is_reached: bool
    time_s: float
    times: np.ndarray
    poses: np.ndarray
    speeds: np.ndarray
    off_goal: np.ndarray
    gaps: np.ndarray
    contacts: tuple[Contact, ...]
    states: tuple[tuple[float, str, str], ...]
    people: dict[str, np.ndarray]

    @property
    def path_m(self) -> float:
        """Way driven, m."""
        return float(np.hypot(*np.diff(self.poses[:, :2], axis=0).T).sum())

    @property
    def min_gap_m(self) -> float:
        """Least distance to a person, m."""
        return float(self.gaps.min(initial=math.inf))

    @property
    def has_touched(self) -> bool:
        """Whether anything was touched."""
        return bool(self.contacts)

    @property
    def not_moving_s(self) -> float:
        """Time at rest once it had set out, s."""
        return float(_after_start(self.speeds, self.speeds < MOVING).sum()) * self._step

    @property
    def longest_stop_s(self) -> float:
        """Longest time at rest once it had set out, s."""
        still = _after_start(self.speeds, self.speeds < MOVING).astype(int)
        ends = np.flatnonzero(np.diff(np.concatenate(([0], still, [0]))))
        return float((ends[1::2] - ends[0::2]).max(initial=0)) * self._step

    @property
    def heading_changes(self) -> int:
        """Number of turns by more than 15 degrees one way; a turn and back are two."""
        return count_turns(np.unwrap(self.poses[:, 2]), TURN_RAD)

    @property
    def turned_rad(self) -> float:
        """Sum of all turning, rad."""
        return float(np.abs(np.diff(np.unwrap(self.poses[:, 2]))).sum())

    @property
    def most_off_rad(self) -> float:
        """Largest angle between where the robot faced and the goal, rad."""
        return float(np.abs(self.off_goal).max(initial=0.0))

    @property
    def _step(self) -> float:
        return float(self.times[1] - self.times[0]) if len(self.times) > 1 else 0.0


def _after_start(speeds: np.ndarray, what: np.ndarray) -> np.ndarray:
    is_under_way = np.maximum.accumulate(speeds >= MOVING) if len(speeds) else speeds > 0.0
    return what & is_under_way


def count_turns(yaws: np.ndarray, least: float) -> int:
    """Return how many turns by more than `least` one way there are in a course of headings.

    Args:
        yaws: Unwrapped headings, shape (N,), rad.
        least: What counts, rad.
    """
    num, way = 0, 0
    low = high = float(yaws[0]) if len(yaws) else 0.0
    for yaw in yaws:
        low, high = min(low, float(yaw)), max(high, float(yaw))
        if way <= 0 and yaw - low > least:
            num, way, high = num + 1, 1, float(yaw)
        elif way >= 0 and high - yaw > least:
            num, way, low = num + 1, -1, float(yaw)
        if way > 0:
            low = high
        elif way < 0:
            high = low
    return num


class Judge:
    """Watches one drive.

    Args:
        simulation: Where it is.
        model: Of the robot.
        goal: In the world, m.
    """

    def __init__(
        self, simulation: Simulation, model: RobotModel, goal: tuple[float, float]
    ) -> None:
        self.contacts: list[Contact] = []
        self._outline = np.array(model.config.footprint_m)
        self._radius = simulation.world.people_model.torso_radius_m
        self._goal = np.array([goal])
        self._rows: list[tuple[float, ...]] = []
        self._states: list[tuple[float, str, str]] = []
        self._people: dict[str, list[tuple[float, float, float]]] = {}
        self._touched_at: dict[str, float] = {}

    def decided(self, time_s: float, decision: Decision) -> None:
        """Take what the method said."""
        if not self._states or self._states[-1][1:] != (decision.state, decision.reason):
            self._states.append((time_s, decision.state, decision.reason))

    def note(self, seen: Observations, name: str) -> None:
        """Take what is so after a step."""
        truth, people = seen.robots[name].ground_truth, seen.ground_truth_people
        time_s, pose, v = seen.stamp_ns * 1e-9, truth.pose, truth.velocity
        to_goal = (pose.inverse() @ self._goal)[0]
        places = np.array([(p.pose.x, p.pose.y) for p in people]).reshape(-1, 2)
        gaps = gap_to(pose @ self._outline, places) - self._radius
        self._rows.append((
            time_s, pose.x, pose.y, pose.yaw, math.hypot(v.speed, v.side_speed),
            math.atan2(to_goal[1], to_goal[0]), float(gaps.min(initial=math.inf)),
        ))  # fmt: skip
        if len(self._rows) % _TRACK_EVERY == 1:
            for person in people:
                row = (time_s, person.pose.x, person.pose.y)
                self._people.setdefault(person.name, []).append(row)
        motion = v.speed, v.side_speed, v.yaw_rate
        self._note_contacts(time_s, truth.is_touching, pose, motion, people, gaps)

    def result(self, is_reached: bool) -> Drive:
        """Return what came of it."""
        rows = np.array(self._rows).reshape(-1, 7)
        return Drive(
            is_reached=is_reached, time_s=float(rows[-1, 0]) if len(rows) else 0.0,
            times=rows[:, 0], poses=rows[:, 1:4], speeds=rows[:, 4], off_goal=rows[:, 5],
            gaps=rows[:, 6], contacts=tuple(self.contacts), states=tuple(self._states),
            people={name: np.array(track) for name, track in self._people.items()},
        )  # fmt: skip

    def _note_contacts(
        self, time_s: float, is_touching: bool, pose: SE2, motion: tuple[float, float, float],
        people: tuple[PersonTruth, ...], gaps: np.ndarray,
    ) -> None:  # fmt: skip
        *velocity, yaw_rate = motion
        met = set(np.flatnonzero(gaps <= 0.0).tolist())
        if is_touching and not met and len(gaps) and gaps.min() < _LEG_REACH:
            met = {int(np.argmin(gaps))}
        for k in met:
            place = np.array([[people[k].pose.x, people[k].pose.y]])
            by_robot = is_by_robot(self._outline, (pose.inverse() @ place)[0], velocity, yaw_rate)
            self._add(time_s, people[k].name, by_robot)
        if is_touching and not met:
            self._add(time_s, "", math.hypot(*velocity) > MOVING)

    def _add(self, time_s: float, name: str, by_robot: bool) -> None:
        last = self._touched_at.get(name, -math.inf)
        self._touched_at[name] = time_s
        if time_s - last > _CONTACT_S:
            self.contacts.append(Contact(time_s, name, by_robot))
