"""What the team's localizer says of one robot: its part in an answer, and its clock."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.ros.diagnostics import ERROR, OK, WARN
from multi_localizer.robot_inbox import RobotInbox
from multi_localizer.team_answers import TeamAnswer
from multi_localizer.team_views import NOBODY


def part_in_answer(name: str, answer: TeamAnswer, values: dict[str, object]) -> tuple[bytes, str]:
    """Return how a robot is in an answer; what is known beside it is put into `values`."""
    if name in answer.moment.missing:
        return WARN, answer.moment.missing[name]
    sight = answer.moment.sights[name]
    identities = answer.solution.identities.get(name, np.zeros(0, dtype=int))
    skew_ns = sight.stamp_ns - answer.moment.stamp_ns
    values["bearings"] = len(sight.view.bearings)
    values["bearings with a name"] = int(np.count_nonzero(identities != NOBODY))
    values["taken after the moment (s)"] = f"{skew_ns / 1e9:.3f}"
    values["has its own pose"] = sight.view.rough is not None
    if name not in answer.bases:
        if name in answer.solution.suspects:
            return ERROR, "contradicts the others, and they do not confirm where it is"
        if name in answer.solution.estimates:
            return WARN, "too little of what it sees fits anybody"
        return WARN, answer.solution.unobservable or answer.solution.problem or "not located"
    sd = np.sqrt(np.diag(answer.bases[name].cov))
    values["deviation (m)"] = f"{math.hypot(sd[0], sd[1]):.3f}"
    values["deviation (deg)"] = f"{math.degrees(sd[2]):.2f}"
    if name in answer.solution.suspects:
        return WARN, "located by the others, which its own pose contradicts"
    if sight.view.rough is None:
        return WARN, "located without a pose of its own"
    return OK, "located"


def clock_values(robot: RobotInbox) -> dict[str, object]:
    """Return how far a robot's clock is ahead, in words."""
    offset = robot.clock.offset
    if offset is None:
        return {"clock offset (s)": "not known"}
    error = "one way" if offset.error_ns is None else f"{offset.error_ns / 1e9:.4f}"
    return {"clock offset (s)": f"{offset.offset_ns / 1e9:.4f}", "its error (s)": error}
