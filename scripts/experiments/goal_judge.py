"""What came of a drive over several goals, by the truth of the simulation.

The same judge serves the graph that ran over DDS and the run in lockstep beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.goal_record import GoalRecord
from experiments.planner_contacts import gap_to
from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

LONG_STOP_S = 5.0
SAME_TOUCH_S = 1.0  # touching the same again within this is the same collision
_MOVING, _TURNING = 0.05, 0.05  # m/s, rad/s
_LEG_REACH = 0.3  # of a leg beyond the torso, with some air, m
_TOUCH_M = 0.08  # a thing this near the outline is what was touched
_SMOOTH_S = 0.2


@dataclass(frozen=True)
class Collision:
    """One touch.

    Attributes:
        time_s: When.
        what: Name of the thing, "a person", or "glass".
        place: Of the robot then, x and y, m.
    """

    time_s: float
    what: str
    place: tuple[float, float]


@dataclass(frozen=True)
class Surroundings:
    """What a drive is judged by.

    Attributes:
        outline: Of the robot in its own frame, (C, 2), m.
        solids: What stands there, panes among it.
        torso_radius: Of a person, m.
    """

    outline: np.ndarray
    solids: Sequence[Solid]
    torso_radius: float


def judge(record: GoalRecord, around: Surroundings) -> dict[str, Any]:
    """Return the figures of a drive, as they stand in `summary.json`."""
    touches = collisions(record, around)
    stops = long_stops(record)
    return {
        "goals": record.num_goals,
        "reached": len(record.reached_ns),
        "collisions": len(touches),
        "glass_touched": sum(touch.what == "glass" for touch in touches),
        "stops_over_5s": len(stops),
        "stopped_s": stopped_s(record),
        "time_s": round(record.sim_s, 2),
        "path_m": record.path_m,
        "touched": [
            {"what": t.what, "time_s": round(t.time_s, 2), "place_m": t.place} for t in touches
        ],
    }


def collisions(record: GoalRecord, around: Surroundings) -> list[Collision]:
    """Return all touches; one that lasts, or comes again within a second, is one."""
    found: list[Collision] = []
    last: dict[str, float] = {}
    for start_ns, end_ns in _spans(record):
        pose = _pose_at(record, start_ns)
        if pose is None:
            continue
        what, time_s = touched(pose, _people_at(record, start_ns), around), start_ns * 1e-9
        if time_s - last.get(what, -np.inf) > SAME_TOUCH_S:
            found.append(Collision(time_s, what, (round(pose.x, 2), round(pose.y, 2))))
        last[what] = end_ns * 1e-9
    return found


def touched(pose: SE2, people: np.ndarray, around: Surroundings) -> str:
    """Return what a robot at a pose touches: the nearest thing there, glass before its frame."""
    outline = pose @ around.outline
    gaps = gap_to(outline, people) - around.torso_radius
    nearest = gaps.min(initial=np.inf)
    things = [(_gap(outline, solid), solid) for solid in around.solids]
    things = [(gap, solid) for gap, solid in things if gap < _TOUCH_M]
    if nearest < min([gap for gap, _ in things], default=_LEG_REACH):
        return "a person"
    if any(solid.glass is not None for _, solid in things):
        return "glass"
    return min(things, key=lambda thing: thing[0])[1].name if things else "something"


def long_stops(record: GoalRecord) -> list[tuple[float, float]]:
    """Return from when to when the robot stood for over 5 s on its way, s.

    Turning on the spot is no standing; what is before it set out and behind the last goal counts
    not.
    """
    return [(a, b) for a, b in _stops(record) if b - a > LONG_STOP_S]


def stopped_s(record: GoalRecord) -> float:
    """Return the time at rest on the way, s."""
    return round(sum(b - a for a, b in _stops(record)), 2)


def _stops(record: GoalRecord) -> list[tuple[float, float]]:
    way = record.way
    if len(way) < 2:
        return []
    step = float(np.median(np.diff(way[:, 0])))
    lag = max(1, round(_SMOOTH_S / step))
    moved, time = way[lag:] - way[:-lag], way[lag:, 0] - way[:-lag, 0]
    turn = np.abs((moved[:, 3] + np.pi) % (2.0 * np.pi) - np.pi)
    is_still = (np.hypot(moved[:, 1], moved[:, 2]) < _MOVING * time) & (turn < _TURNING * time)
    is_under_way = np.maximum.accumulate(~is_still)
    edges = np.diff(np.concatenate(([0], (is_still & is_under_way).astype(int), [0])))
    times = np.append(way[lag:, 0], way[-1, 0])
    return [
        (float(times[a]), float(times[b]))
        for a, b in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True)
    ]


def _spans(record: GoalRecord) -> list[tuple[int, int]]:
    """Return from when to when the robot touched something, ns."""
    end = record.truth[-1][0] if record.truth else 0
    changes = [*record.touches, (end, False)]
    return [(ns, changes[k + 1][0]) for k, (ns, is_on) in enumerate(changes[:-1]) if is_on]


def _pose_at(record: GoalRecord, stamp_ns: int) -> SE2 | None:
    if not record.truth:
        return None
    return min(record.truth, key=lambda item: abs(item[0] - stamp_ns))[1]


def _people_at(record: GoalRecord, stamp_ns: int) -> np.ndarray:
    if not record.people:
        return np.zeros((0, 2))
    return min(record.people, key=lambda item: abs(item[0] - stamp_ns))[1]


def _gap(outline: np.ndarray, solid: Solid) -> float:
    """Return how far a footprint is from the robot's outline, m."""
    there = solid.outline()
    return float(min(gap_to(outline, there).min(), solid.signed_distance(outline).min()))
