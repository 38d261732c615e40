"""What each robot of a team sees and what is made of it: the data of the team's localizers.

Bearings are angles in the robot's own frame (base_link): 0 ahead, positive to the left. Nobody says
which teammate a bearing belongs to; an identity is the index of a robot in `TeamSolution.names`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate

NOBODY = -1
"""Identity of a bearing that belongs to no robot of the team, or nobody can say to which."""


def _angles(values: object) -> np.ndarray:
    angles = np.array(values, dtype=float)
    if angles.ndim != 1:
        raise ValueError(f"bearings must be of shape (M,), got {angles.shape}")
    angles.flags.writeable = False
    return angles


def _by_class(bearings: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {kind: _angles(values) for kind, values in bearings.items()}


@dataclass(frozen=True, eq=False)
class RobotView:
    """What one robot sees at one moment.

    Attributes:
        name: Of the robot, its namespace.
        bearings: To robots, shape (M,), rad; false ones may be among them, and some robots may not
            be seen. NaN is left out and said.
        landmark_bearings: To landmarks by class, shape (K,) each, rad.
        object_bearings: To other things by class, shape (K,) each, rad; to be located.
        rough: Where the robot believes to be by itself; None if it does not know.
        rough_from_landmarks: Whether `rough` was made from these very `landmark_bearings`: then it
            starts the search, but is not counted a second time.
        bearing_sd: Deviation of its bearings, rad; None for the team's.
        known: Names of the robots that `bearings` belong to, "" where unknown; empty for none.
    """

    name: str
    bearings: np.ndarray
    landmark_bearings: Mapping[str, np.ndarray] = field(default_factory=dict)
    object_bearings: Mapping[str, np.ndarray] = field(default_factory=dict)
    rough: PoseEstimate | None = None
    rough_from_landmarks: bool = False
    bearing_sd: float | None = None
    known: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "bearings", _angles(self.bearings))
        object.__setattr__(self, "landmark_bearings", _by_class(self.landmark_bearings))
        object.__setattr__(self, "object_bearings", _by_class(self.object_bearings))
        if self.bearing_sd is not None and not 0.0 < self.bearing_sd < np.pi:
            raise ValueError(f"bearing_sd must be in (0, pi), got {self.bearing_sd}")
        if self.known and len(self.known) != len(self.bearings):
            raise ValueError(
                f"known must name {len(self.bearings)} bearings or none, got {len(self.known)}"
            )


@dataclass(frozen=True, eq=False)
class ObjectEstimate:
    """Another thing, located from the bearings of two or more robots.

    Attributes:
        kind: Its class.
        position: In the map frame, shape (2,), m.
        cov: Covariance of the position, (2, 2), m^2.
        seen_by: Names of the robots whose bearings made it.
    """

    kind: str
    position: np.ndarray
    cov: np.ndarray
    seen_by: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class TeamSolution:
    """Where the robots of a team are, and who is who in their bearings.

    Attributes:
        names: Of all robots, in the order of the views.
        estimates: Poses in the map frame by name; a robot whose pose cannot be told is left out.
        identities: By name, for each bearing the index in `names` of the robot seen, or `NOBODY`.
        landmark_identities: By name and class, for each bearing the index of the landmark in its
            class, or `NOBODY`.
        objects: Other things located.
        relative: Layout known but for place, turn and size: poses by name, if no more is known.
        unobservable: What the data cannot tell, in words; "" if every pose is determined.
        problem: Why there is no answer at all; "" if there is one.
        notes: Things left out or doubted, in words, such as a bearing that is NaN.
        suspects: Robots whose bearings or rough pose contradict all others.
        joint_cov: Covariance of all estimates, (3 E, 3 E), x, y, yaw of each in the order of
            `estimates`; None where the method has none.
        num_triangles: Triangles found by the published steps; 0 where they did not run.
    """

    names: tuple[str, ...]
    estimates: Mapping[str, PoseEstimate] = field(default_factory=dict)
    identities: Mapping[str, np.ndarray] = field(default_factory=dict)
    landmark_identities: Mapping[str, Mapping[str, np.ndarray]] = field(default_factory=dict)
    objects: tuple[ObjectEstimate, ...] = ()
    relative: Mapping[str, SE2] = field(default_factory=dict)
    unobservable: str = ""
    problem: str = ""
    notes: tuple[str, ...] = ()
    suspects: tuple[str, ...] = ()
    joint_cov: np.ndarray | None = None
    num_triangles: int = 0


def view_problem(views: Sequence[RobotView]) -> str:
    """Return why views cannot be a team's, in words; "" if they can."""
    names = [view.name for view in views]
    if not names:
        return "no robot"
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        return f"two robots have the name {doubled[0]!r}"
    return ""
