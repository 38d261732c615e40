"""A short film of a demo with goals, from above: the map as it grows, glass, robot and people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from _demo_report import OCCUPIED
from experiments.goal_record import GoalRecord
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

FRAMES, FRAME_S = 110, 0.12
_PX_PER_M, _MARGIN_M, _COLORS = 44.0, 0.35, 32
_UNKNOWN, _FREE, _WALL, _GLASS = (217, 221, 226), (255, 255, 255), (18, 23, 31), (26, 158, 204)
_TRUTH, _ROBOT, _PERSON, _GOAL = (150, 185, 235), (26, 127, 75), (224, 134, 26), (179, 19, 75)
_TEXT = (60, 66, 76)
_USED = (_UNKNOWN, _FREE, _WALL, _GLASS, _TRUTH, _ROBOT, _PERSON, _GOAL, _TEXT)
_STRIP_PX = 26  # for the text, below the picture
_FONT = cv2.FONT_HERSHEY_SIMPLEX


MapShot = tuple[int, OccupancyMap, OccupancyMap | None]
"""A stamp (ns), the map then and what of it is glass."""


@dataclass(frozen=True)
class Stage:
    """What stays the same in all frames.

    Attributes:
        solids: What truly stands there.
        goals: In the world, (N, 2), m.
        start: Pose of the maps' frame.
        outline: Of the robot, (C, 2), m.
        torso: Radius of a person, m.
    """

    solids: Sequence[Solid]
    goals: np.ndarray
    start: SE2
    outline: np.ndarray
    torso: float


def write_film(path: Path, record: GoalRecord, maps: Sequence[MapShot], stage: Stage) -> None:
    """Write an animated GIF of a drive."""
    view = _View(stage)
    stamps = np.linspace(record.truth[0][0], record.truth[-1][0], FRAMES).astype(int)
    frames = [view.frame(record, maps, int(stamp)) for stamp in stamps]
    # What is small counts as much as what is large: every color has a stripe of its own.
    stripes = [np.full((24, frames[0].shape[1], 3), color, np.uint8) for color in _USED]
    palette = Image.fromarray(np.vstack((frames[-1], *stripes))).quantize(_COLORS)
    images = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=round(1000 * FRAME_S), loop=0,
        optimize=True,
    )  # fmt: skip


class _View:
    """Draws moments from above, x to the right and y up."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        corners = np.vstack([solid.outline() for solid in stage.solids])
        self._low, high = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
        self._size = np.ceil((high - self._low) * _PX_PER_M).astype(int)

    def frame(self, record: GoalRecord, maps: Sequence[MapShot], stamp_ns: int) -> np.ndarray:
        """Return one picture, (H, W, 3), RGB uint8."""
        width, height = self._size.tolist()
        image = np.full((height + _STRIP_PX, width, 3), _FREE, np.uint8)
        image[:height] = _UNKNOWN
        known = [shot for shot in maps if shot[0] <= stamp_ns]
        if known:
            self._draw_map(image, known[-1])
        for solid in self._stage.solids:
            cv2.polylines(image, [self._px(solid.outline())], True, _TRUTH, 1, cv2.LINE_AA)
        self._draw_goals(image, sum(ns <= stamp_ns for ns in record.reached_ns))
        self._draw_people(image, record, stamp_ns)
        self._draw_robot(image, record, stamp_ns)
        states = [state for ns, state, _ in record.states if ns <= stamp_ns]
        text = f"{stamp_ns * 1e-9:5.1f} s  {states[-1] if states else ''}"
        cv2.putText(image, text, (10, height + 18), _FONT, 0.5, _TEXT, 1, cv2.LINE_AA)
        return image

    def _draw_map(self, image: np.ndarray, shot: MapShot) -> None:
        _, grid, glass = shot
        self._paint(image, grid, (grid.cells >= 0) & (grid.cells < OCCUPIED), _FREE)
        self._paint(image, grid, grid.cells >= OCCUPIED, _WALL)
        if glass is not None:
            self._paint(image, glass, glass.cells >= OCCUPIED, _GLASS)

    def _paint(
        self, image: np.ndarray, grid: OccupancyMap, mask: np.ndarray, color: tuple[int, ...]
    ) -> None:
        rows, columns = mask.shape
        ends = grid.resolution * np.array([[0, 0], [columns, 0], [0, rows]], dtype=float)
        there = self._exact(self._stage.start @ (grid.origin @ ends)).astype(np.float32)
        cut = np.array([[0, 0], [columns, 0], [0, rows]], np.float32)
        T = cv2.getAffineTransform(cut, there)
        size = (image.shape[1], image.shape[0])
        inside = cv2.warpAffine(mask.astype(np.uint8), T, size, flags=cv2.INTER_NEAREST)
        image[inside > 0] = color

    def _draw_goals(self, image: np.ndarray, num_reached: int) -> None:
        for number, place in enumerate(self._px(self._stage.goals)):
            is_next = number == num_reached
            cv2.circle(image, place.tolist(), 9, _GOAL, -1 if is_next else 1, cv2.LINE_AA)
            color = (255, 255, 255) if is_next else _GOAL
            at = (int(place[0]) - 4, int(place[1]) + 4)
            cv2.putText(image, str(number + 1), at, _FONT, 0.4, color, 1, cv2.LINE_AA)

    def _draw_people(self, image: np.ndarray, record: GoalRecord, stamp_ns: int) -> None:
        seen = [places for stamp, places in record.people if stamp <= stamp_ns]
        for place in self._px(seen[-1]) if seen else ():
            radius = round(self._stage.torso * _PX_PER_M)
            cv2.circle(image, place.tolist(), radius, _PERSON, -1, cv2.LINE_AA)

    def _draw_robot(self, image: np.ndarray, record: GoalRecord, stamp_ns: int) -> None:
        poses = [pose for stamp, pose in record.truth if stamp <= stamp_ns]
        way = np.array([(pose.x, pose.y) for pose in poses[::10]]).reshape(-1, 2)
        cv2.polylines(image, [self._px(way)], False, _ROBOT, 2, cv2.LINE_AA)
        cv2.fillPoly(image, [self._px(poses[-1] @ self._stage.outline)], _ROBOT, cv2.LINE_AA)

    def _exact(self, points: np.ndarray) -> np.ndarray:
        off = (points - self._low) * _PX_PER_M
        return np.column_stack((off[:, 0], self._size[1] - off[:, 1]))

    def _px(self, points: np.ndarray) -> np.ndarray:
        return np.rint(self._exact(points)).astype(np.int32)
