"""Poses that two or three sightings give in closed form: where the search for the pose begins."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.landmark_circle import circle_of_pair, meet_again, pose_at
from multi_localizer.landmark_fit import Sighting
from multi_localizer.landmark_floor import floor_fix
from multi_localizer.landmarks import Landmark, Landmarks

_LOOKS, _MOST = 2, 4


def choices(seen: Sequence[Sighting]) -> list[tuple[int, ...]]:
    """Return which sightings to start from: pairs with a distance, then triples of bearings.

    Those that are spread best come first.
    """
    numbers = range(len(seen))
    pairs = [c for c in itertools.combinations(numbers, 2) if _num_values(seen, c) > 2]
    triples = list(itertools.combinations(numbers, 3))

    def worth(chosen: tuple[int, ...]) -> tuple[int, float]:
        gaps = [
            abs(math.sin(0.5 * (seen[i].bearing - seen[j].bearing)))
            for i, j in itertools.combinations(chosen, 2)
        ]
        return -_num_values(seen, chosen), -min(gaps)

    return sorted(pairs, key=worth) + sorted(triples, key=worth)


def refined_poses(
    seen: Sequence[Sighting], marks: Sequence[Landmark], place: np.ndarray
) -> list[SE2]:
    """Return the poses that sightings of landmarks give.

    Which end of a wide landmark is seen depends on the place, so poses are found again from where
    the last ones are.

    Args:
        seen: Two or three sightings.
        marks: The landmark of each.
        place: Where ends are seen from at first, (2,), m.
    """
    poses = poses_of(seen, np.array([mark.point_seen(place) for mark in marks]))
    if all(len(mark.corners) == 1 for mark in marks):
        return poses
    found, newest = list(poses), poses
    for _ in range(_LOOKS):
        newest = [
            again
            for pose in newest
            for again in poses_of(
                seen, np.array([m.point_seen(np.array([pose.x, pose.y])) for m in marks])
            )
        ][:_MOST]
        found += newest
    return found


def poses_of(seen: Sequence[Sighting], points: np.ndarray) -> list[SE2]:
    """Return the poses in which two or three sightings are of landmarks at points (N, 2), m."""
    bearings = np.array([s.bearing for s in seen])
    if len(seen) > 2:
        place = _by_three(points, bearings)
        return [] if place is None else [pose_at(place, points, bearings)]
    if all(s.num_values == 2 for s in seen):
        rays = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
        pose = floor_fix(points, rays * np.array([[s.distance] for s in seen]))
        return [] if pose is None else [pose]
    near = int(seen[1].num_values == 2)
    return _by_one_distance(points, bearings, near, seen[near].distance)


def rough_costs(
    poses: Sequence[SE2], seen: Sequence[Sighting], landmarks: Landmarks, limit: float
) -> np.ndarray:
    """Return what poses (N) cost: squared deviations from the nearest landmarks, none over a limit.

    Several sightings may take the same landmark: good enough to rank poses by.
    """
    places = np.array([(pose.x, pose.y) for pose in poses])
    yaws = np.array([pose.yaw for pose in poses])
    costs = np.zeros(len(poses))
    rays = {
        kind: np.array([mark.points_seen(places) - places for mark in landmarks[kind]])
        for kind in {s.kind for s in seen}
    }
    for s in seen:
        x, y = rays[s.kind][..., 0], rays[s.kind][..., 1]
        # wrap_angle of whole arrays
        off = np.remainder(np.arctan2(y, x) - yaws - s.bearing + math.pi, 2.0 * math.pi) - math.pi
        cost = np.minimum((off / s.bearing_sd) ** 2, limit)
        if s.num_values == 2:
            far = ((np.hypot(x, y) - s.distance) / s.distance_sd) ** 2
            cost = cost + np.minimum(far, 0.5 * limit)
        costs += cost.min(axis=0)
    return costs


def _by_three(points: np.ndarray, bearings: np.ndarray) -> np.ndarray | None:
    """Return where the circles through the first two and the last two of three meet."""
    first = circle_of_pair(points[0], points[1], bearings[1] - bearings[0])
    second = circle_of_pair(points[1], points[2], bearings[2] - bearings[1])
    return None if first is None or second is None else meet_again(first, second, points[1])


def _by_one_distance(
    points: np.ndarray, bearings: np.ndarray, near: int, distance: float
) -> list[SE2]:
    """Return where the circle of a pair is a distance away from one of the two."""
    circle = circle_of_pair(points[0], points[1], bearings[1] - bearings[0])
    if circle is None or distance > 2.0 * circle.radius:
        return []
    way = circle.center - points[near]
    toward = math.atan2(way[1], way[0])
    turn = math.acos(distance / (2.0 * circle.radius))  # of a chord from the diameter
    places = [
        points[near] + distance * np.array([math.cos(a), math.sin(a)])
        for a in (toward - turn, toward + turn)
    ]
    return [pose_at(place, points, bearings) for place in places]


def _num_values(seen: Sequence[Sighting], chosen: tuple[int, ...]) -> int:
    return sum(seen[k].num_values for k in chosen)
