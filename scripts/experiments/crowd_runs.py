"""One run of the crowd experiment, what is kept of it, and the figures of many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.crowd_recorded import recorded
from experiments.crowd_scenes import ROBOT, SCENES, Scene
from experiments.planner_drives import Course, drive_course
from experiments.planner_judge import Drive
from experiments.planner_peers import PEERS
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.methods import METHODS, make_method
from sjmc_planner.planning import Method

SJMC_DISK = "sjmc_disk"  # told no more of the robot's outline than the others: the disk around it
ALL_METHODS = (*METHODS, SJMC_DISK, *PEERS)
LIMIT_S = 60.0
LONG_STOP_S = 5.0
NUM_PICTURED = 2  # the first runs, of which ways are kept
INTIMATE_M, PERSONAL_M = 0.45, 1.2  # Hall 1966, between the bodies


@dataclass(frozen=True)
class Task:
    """A run to make: in which scene, of which number, by which method.

    Attributes:
        scene: Name of a scene, or of a recording.
        number: The run's: with the seed it settles people and ways.
        method: One of `ALL_METHODS`.
        seed: Of the experiment.
        people: File of the recording; "" for a simulated scene.
        frames_per_s: Of its video.
    """

    scene: str
    number: int
    method: str
    seed: int
    people: str = ""
    frames_per_s: float = 25.0


@dataclass(frozen=True)
class Outcome:
    """What is kept of a run.

    Attributes:
        is_success: Reached in time, without a contact that the robot caused.
        is_reached: Reached in time.
        caused: Contacts with people that the robot caused.
        theirs: Contacts with people that they caused.
        things: Contacts with things.
        time_s: Until it was there.
        path_ratio: Way driven over the straight line between its ends.
        min_distance_m: Least distance between its outline and anybody's body.
        not_moving_s: Time at rest after it set out.
        longest_stop_s: The longest rest.
        heading_changes: Turns by more than 15 degrees.
        intimate_s: Time with somebody nearer than 0.45 m.
        personal_s: Time with somebody nearer than 1.2 m.
        all_yield: Whether everybody notices sooner or later.
        track: x, y, yaw every 0.5 s, shape (N, 3).
        people: t, x, y of everybody, by name.
    """

    is_success: bool
    is_reached: bool
    caused: int
    theirs: int
    things: int
    time_s: float
    path_ratio: float
    min_distance_m: float
    not_moving_s: float
    longest_stop_s: float
    heading_changes: int
    intimate_s: float
    personal_s: float
    all_yield: bool
    track: np.ndarray
    people: dict[str, np.ndarray]


def scene_of(task: Task) -> Scene:
    """Return where a run takes place."""
    seed = _seed(task)
    if task.people:
        return recorded(Path(task.people), task.frames_per_s, seed)
    return SCENES[task.scene](seed)


def run_task(task: Task) -> Outcome:
    """Make a run; the same task gives the same outcome, in any process."""
    scene = scene_of(task)
    course = Course(scene.world, scene.goal, LIMIT_S, is_over=scene.is_finished)
    drive = drive_course(course, _method(task.method), ROBOT, _seed(task))
    outcome = _outcome(drive, scene)
    if task.number < NUM_PICTURED:
        return outcome
    return replace(outcome, track=outcome.track[:0], people={})


def _seed(task: Task) -> int:
    return 10_000 * task.seed + task.number


def _method(name: str) -> Method:
    if name in PEERS:
        return PEERS[name](LocalPlannerConfig(robot=ROBOT, goal_tolerance_m=0.2))
    if name == SJMC_DISK:
        disk = replace(ROBOT, front_m=0.0, rear_m=0.0, half_width_m=0.0)
        return make_method(LocalPlannerConfig(method="sjmc", robot=disk, goal_tolerance_m=0.2))
    return make_method(LocalPlannerConfig(method=name, robot=ROBOT, goal_tolerance_m=0.2))


def _outcome(drive: Drive, scene: Scene) -> Outcome:
    with_people = [contact for contact in drive.contacts if contact.name]
    caused = sum(contact.by_robot for contact in with_people)
    step = float(drive.times[1] - drive.times[0])
    straight = float(np.hypot(*(drive.poses[-1, :2] - drive.poses[0, :2])))
    return Outcome(
        is_success=drive.is_reached and not caused, is_reached=drive.is_reached, caused=caused,
        theirs=len(with_people) - caused, things=len(drive.contacts) - len(with_people),
        time_s=drive.time_s, path_ratio=drive.path_m / max(straight, 1e-9),
        min_distance_m=drive.min_gap_m, not_moving_s=drive.not_moving_s,
        longest_stop_s=drive.longest_stop_s, heading_changes=drive.heading_changes,
        intimate_s=step * float((drive.gaps < INTIMATE_M).sum()),
        personal_s=step * float((drive.gaps < PERSONAL_M).sum()),
        all_yield=scene.all_yield, track=drive.poses[::50].astype(np.float32), people=drive.people,
    )  # fmt: skip


def figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return the figures of one method in one scene; times and ways are of the runs it finished."""
    there = [o for o in outcomes if o.is_reached]
    yielding = [o for o in outcomes if o.all_yield]
    return {
        "runs": len(outcomes),
        "success": _mean([o.is_success for o in outcomes]),
        "reached": _mean([o.is_reached for o in outcomes]),
        "collisions_caused": sum(o.caused for o in outcomes),
        "collisions_theirs": sum(o.theirs for o in outcomes),
        "collisions_things": sum(o.things for o in outcomes),
        "time_s": _mean([o.time_s for o in there]),
        "path_ratio": _mean([o.path_ratio for o in there]),
        "min_distance_m": _mean([max(o.min_distance_m, 0.0) for o in outcomes]),
        "time_not_moving_s": _mean([o.not_moving_s for o in outcomes]),
        "heading_changes": _mean([o.heading_changes for o in outcomes]),
        "intimate_s": _mean([o.intimate_s for o in outcomes]),
        "personal_s": _mean([o.personal_s for o in outcomes]),
        "longest_stop_s": max((o.longest_stop_s for o in outcomes), default=None),
        "long_stops_where_all_yield": sum(o.longest_stop_s > LONG_STOP_S for o in yielding),
        "runs_where_all_yield": len(yielding),
    }


def _mean(values: Sequence[float]) -> float | None:
    finite = [float(v) for v in values if np.isfinite(v)]
    return float(np.mean(finite)) if finite else None


def beside(ours: dict[int, Outcome], theirs: dict[int, Outcome]) -> dict[str, float | int | None]:
    """Return time and heading changes over another method's, of the same runs.

    Args:
        ours: Outcomes by the number of the run.
        theirs: The other method's.

    Returns:
        `runs` both made and `time` over them, where a run without success counts with the time
        limit, so that none gains by freezing or by a contact; `runs_both` in which both had
        success, and `time_both` and `heading_changes` over these.
    """
    shared = [n for n in ours if n in theirs]
    both = [n for n in shared if ours[n].is_success and theirs[n].is_success]
    pairs = [(ours[n], theirs[n]) for n in both]
    return {
        "runs": len(shared),
        "runs_both": len(both),
        "time": _ratio([(_charged(ours[n]), _charged(theirs[n])) for n in shared]),
        "time_both": _ratio([(a.time_s, b.time_s) for a, b in pairs]),
        "heading_changes": _ratio([(a.heading_changes, b.heading_changes) for a, b in pairs]),
    }


def _charged(outcome: Outcome) -> float:
    return outcome.time_s if outcome.is_success else LIMIT_S


def _ratio(pairs: Sequence[tuple[float, float]]) -> float | None:
    below = sum(b for _, b in pairs)
    return sum(a for a, _ in pairs) / below if below else None
