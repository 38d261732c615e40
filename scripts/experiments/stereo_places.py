"""What the robot's two pairs see at places of the stereo room, by each way to get distances."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from experiments.stereo_views import StereoRoom, View
from floornav_common.se2 import SE2
from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_fill import fill_from_farther
from multi_localizer.stereo_matcher import StereoMatcher
from multi_localizer.stereo_view import StereoView, observe
from multi_localizer.voxel_view import ViewCamera

MATCHERS = ("interval_dp", "monotone_dp", "ours")
TRUE = "true_disparity"
SOURCES = (*MATCHERS, TRUE)


@dataclass(frozen=True, eq=False)
class Place:
    """A pose and what is seen there.

    Attributes:
        pose: `T_world_base`.
        seen: What each pair sees, by its name.
        views: The same reduced to 320 x 8 pixels, one a pair, by where distances are from.
    """

    pose: SE2
    seen: Mapping[str, View]
    views: Mapping[str, list[StereoView | None]]


class Observer:
    """Renders, matches and reduces.

    Args:
        room: The room.
        sources: Where distances are from: names of `SOURCES`.

    Attributes:
        cameras: The left camera of each pair.
    """

    def __init__(self, room: StereoRoom, sources: tuple[str, ...] = SOURCES) -> None:
        self._room, self._sources = room, sources
        self.cameras = cameras_of(room)
        self._matchers = {
            name: StereoMatcher(StereoMatcherConfig(method=name))
            for name in sources
            if name in MATCHERS
        }

    def look(self, pose: SE2, frame: int) -> Place:
        """Return what is seen at a pose, with the noise of a frame's number."""
        seen = {pair: self._room.view(pose, frame, pair) for pair in self._room.T_base_left}
        views = {source: self._reduced(source, seen) for source in self._sources}
        return Place(pose, seen, views)

    def disparity(self, source: str, view: View) -> np.ndarray:
        """Return the disparities of a view, (H, W), float32, px.

        The paper's matchers leave no holes: those that stay at an image's edge are filled from the
        farther neighbor. Ours says where it knows nothing.
        """
        if source == TRUE:
            scale = self._room.focal_px * self._room.baseline_m
            return np.asarray(scale / view.depth, dtype=np.float32)
        found = self._matchers[source].match(view.left, view.right)
        return found if source == "ours" else fill_from_farther(found)

    def _reduced(self, source: str, seen: Mapping[str, View]) -> list[StereoView | None]:
        return [
            observe(self.disparity(source, view), view.left, camera, self._room.farthest_m)
            for view, camera in zip(seen.values(), self.cameras, strict=True)
        ]


def cameras_of(room: StereoRoom) -> list[ViewCamera]:
    """Return the left camera of each pair."""
    cameras = []
    for T in room.T_base_left.values():
        x, y, z = T[:3, 3]
        yaw = math.atan2(T[1, 2], T[0, 2])
        cameras.append(
            ViewCamera(
                *room.size_px, room.focal_px, room.baseline_m, float(z), float(x), float(y), yaw
            )
        )
    return cameras


def random_places(
    room: StereoRoom, num: int, seed: int, look: Callable[[SE2, int], Place]
) -> list[Place]:
    """Return places drawn at random, the robot standing free at each."""
    rng = np.random.default_rng(seed)
    return [look(room.standing_pose(rng), k) for k in range(num)]
