"""How often the published step (team paper, 3.2.3) finds a triangle in the five-robot recording.

Once a second the bearings of the last second are turned to that instant by the odometry's yaw and
given to it without names, of each robot the newest: that several of one second show the same robot
is told by its true name, which makes the task easier than it is. Rough poses are those of the
robots alone. A triangle needs three robots that all see each other, which cameras of 34 degrees to
each side seldom do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.mrclam_measures import SKIP_S
from experiments.mrclam_recording import TeamRecording
from experiments.mrclam_runs import Track
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_published import solve_published
from multi_localizer.team_views import RobotView, TeamSolution

WINDOW_S = 1.0


@dataclass(frozen=True)
class Triangles:
    """Instants tried, once a second.

    Attributes:
        num_instants: All.
        num_pairs: Those at which two robots had each other among their bearings.
        num_mutual: Those at which three did, each both others.
        num_found: Those at which the published step found a triangle.
        num_right: Those whose every bearing it gave to the right robot.
    """

    num_instants: int
    num_pairs: int
    num_mutual: int
    num_found: int
    num_right: int


def count_triangles(recording: TeamRecording, alone: Track, delay: float) -> Triangles:
    """Try the published step at every second.

    Args:
        recording: Identities are used to judge only.
        alone: Rough poses.
        delay: Of the odometry, s.
    """
    after = alone.times - recording.start
    rows = [int(np.argmax(after >= t)) for t in np.arange(SKIP_S, after[-1], 1.0)]
    yaws = {k: log.dead_reckoned(alone.times, delay)[:, 2] for k, log in recording.robots.items()}
    at_look = {
        k: log.dead_reckoned(log.looks[:, 0], delay)[:, 2] for k, log in recording.robots.items()
    }
    num_pairs = num_mutual = num_found = num_right = 0
    for row in rows:
        views, truly = [], {}
        for column, k in enumerate(recording.robots):
            looks = recording.robots[k].looks
            age = alone.times[row] - looks[:, 0]
            chosen = (age >= 0.0) & (age < WINDOW_S) & np.isin(looks[:, 1], [*recording.robots])
            newest = {int(looks[i, 1]): i for i in np.flatnonzero(chosen)}
            turned = yaws[k][row] - at_look[k][list(newest.values())]
            bearings = looks[list(newest.values()), 2] - turned
            views.append(RobotView(str(k), bearings, rough=_rough(alone, row, column)))
            truly[str(k)] = [str(subject) for subject in newest]
        mutual = _mutual({k: set(seen) for k, seen in truly.items()})
        num_pairs += bool(mutual)
        num_mutual += any((a, b) in mutual and (b, c) in mutual for a, c in mutual for b in truly)
        solution = solve_published(views, {})
        if solution.num_triangles:
            num_found += 1
            num_right += _is_right(solution, truly)
    return Triangles(len(rows), num_pairs, num_mutual, num_found, num_right)


def _rough(alone: Track, row: int, column: int) -> PoseEstimate | None:
    pose = alone.poses[row, column]
    if not np.isfinite(pose[0]):
        return None
    return PoseEstimate(SE2(*(float(value) for value in pose)), alone.covs[row, column])


def _mutual(seen: dict[str, set[str]]) -> set[tuple[str, str]]:
    """Return the pairs that see each other, each both ways round."""
    return {(a, b) for a in seen for b in seen[a] if b in seen and a in seen[b]}


def _is_right(solution: TeamSolution, truly: dict[str, list[str]]) -> bool:
    for name, identities in solution.identities.items():
        for identity, true_name in zip(identities, truly[name], strict=True):
            if identity >= 0 and solution.names[identity] != true_name:
                return False
    return True
