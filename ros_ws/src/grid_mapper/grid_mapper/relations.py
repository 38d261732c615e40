"""How well a trajectory keeps the known relations between its poses.

Kuemmerle et al., On measuring the accuracy of SLAM algorithms, Auton. Robots 27, 2009: not the
poses are compared but the motions between pairs of them, which people verified by hand; where the
map frame lies does not matter, and an error early on does not count again for every later pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.recordings.ordering import seconds_to_ns
from grid_mapper.recordings.text_lines import read_lines


@dataclass(frozen=True)
class Relation:
    """A known motion: the pose at `stamp2_ns` seen from the pose at `stamp1_ns`."""

    stamp1_ns: int
    stamp2_ns: int
    T_1_2: SE2


@dataclass(frozen=True)
class RelationErrors:
    """Errors of the relations whose two stamps are both in a trajectory.

    Attributes:
        relations: The relations that were used.
        translations: Length of each translational error, shape (N,), m.
        rotations: Size of each rotational error, shape (N,), rad.
        num_total: Relations asked for, used or not.
    """

    relations: tuple[Relation, ...]
    translations: np.ndarray
    rotations: np.ndarray
    num_total: int

    def worst(self, count: int) -> list[tuple[Relation, float, float]]:
        """Return the relations with the greatest translational errors, and both their errors."""
        order = np.argsort(-self.translations, kind="stable")[:count]
        return [
            (self.relations[i], float(self.translations[i]), float(self.rotations[i]))
            for i in order
        ]


def load_relations(path: Path) -> list[Relation]:
    """Read lines of `t1 t2 x y z roll pitch yaw`, plain or gzip; s, m and rad.

    Raises:
        ValueError: If a line is not of this layout, or there is none.
    """
    relations: list[Relation] = []
    for number, line in enumerate(read_lines(path, _refuse), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            x, y, yaw = float(words[2]), float(words[3]), float(words[7])
            stamps = seconds_to_ns(words[0]), seconds_to_ns(words[1])
        except (ValueError, IndexError):
            raise ValueError(
                f"{path} line {number} is not `t1 t2 x y z roll pitch yaw`: {line[:60]!r}"
            ) from None
        relations.append(Relation(*stamps, SE2(x, y, yaw)))
    if not relations:
        raise ValueError(f"{path} holds no relation")
    return relations


def _refuse(problem: str) -> None:
    raise ValueError(problem)


def relation_errors(
    trajectory: Sequence[tuple[int, SE2]],
    relations: Sequence[Relation],
    tolerance_ns: int,
    offset_ns: int = 0,
) -> RelationErrors:
    """Compare a trajectory with relations; the nearest pose is taken, none is interpolated.

    Args:
        trajectory: Stamps (ns, any order) and poses.
        relations: The known motions.
        tolerance_ns: How far a stamp of a relation may be from the nearest pose.
        offset_ns: Added to the trajectory's stamps.

    Returns:
        The errors of the relations with a pose at both stamps.
    """
    ordered = sorted(((stamp_ns + offset_ns, i) for i, (stamp_ns, _) in enumerate(trajectory)))
    stamps = np.array([stamp for stamp, _ in ordered], dtype=np.int64)
    used: list[Relation] = []
    errors: list[SE2] = []
    for relation in relations:
        i = _nearest(stamps, relation.stamp1_ns, tolerance_ns)
        j = _nearest(stamps, relation.stamp2_ns, tolerance_ns)
        if i is None or j is None:
            continue
        pose1, pose2 = trajectory[ordered[i][1]][1], trajectory[ordered[j][1]][1]
        used.append(relation)
        errors.append(relation.T_1_2.between(pose1.between(pose2)))
    return RelationErrors(
        relations=tuple(used),
        translations=np.array([error.distance for error in errors]),
        rotations=np.array([abs(error.yaw) for error in errors]),
        num_total=len(relations),
    )


def _nearest(stamps: np.ndarray, stamp_ns: int, tolerance_ns: int) -> int | None:
    """Return the index of the stamp nearest to another; None if it is too far."""
    right = int(np.searchsorted(stamps, stamp_ns))
    around = [i for i in (right - 1, right) if 0 <= i < len(stamps)]
    if not around:
        return None
    best = min(around, key=lambda i: abs(int(stamps[i]) - stamp_ns))
    return best if abs(int(stamps[best]) - stamp_ns) <= tolerance_ns else None
