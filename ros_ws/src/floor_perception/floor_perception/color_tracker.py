"""Keeps the floor's color as the light changes, from a ring on the floor around the robot.

The ring is divided into directions. The color follows slowly what the ring's floor-colored pixels
show, as long as enough directions have them: an obstacle that the robot touches has another color,
so its pixels do not count, and it covers the ring only in part. A sudden change of light leaves no
floor-colored pixel; the color is learned anew only if nearly the whole ring has had one other color
for a while, which no obstacle can cause.

An obstacle may have the floor's hue and be darker, as a shadow is. So the floor is followed where
it is about as bright as it was, or where it is equally bright all around, and as long as something
may hide a part of the ring the color stays near what the whole ring showed last.
"""

from __future__ import annotations

import numpy as np

from floor_perception.color_model import (
    FloorColor,
    followed,
    has_color,
    is_near,
    learn,
    response_part,
)
from floor_perception.config import ColorConfig
from floor_perception.first_color import learn_first

_NUM_SECTORS = 24
_SECTOR_SHARE = 0.5
_MAX_PIXELS = 1000
_MAX_FIRST_PIXELS = 4000
_MIN_PIXELS = 50
_ALIKE = 1.25  # ratio of brightnesses in one light


class ColorTracker:
    """The floor's color through time.

    Args:
        config: Shares and times.
        pixels: Row and column of the ring's pixels, (N, 2).
        points: Where they lie on the floor, (N, 2), m.
        color: To start with; None learns it from the first image.

    Attributes:
        color: The floor's now; None before it was learned.
        support: Share of the ring's directions that showed it last.
        reason: Why there is no color, or why it does not follow; "" if it does.
    """

    def __init__(
        self,
        config: ColorConfig,
        pixels: np.ndarray,
        points: np.ndarray,
        color: FloorColor | None = None,
    ) -> None:
        first = max(1, -(-len(pixels) // _MAX_FIRST_PIXELS))
        self._first_pixels, self._first_points = pixels[::first], points[::first]
        step = max(1, -(-len(pixels) // _MAX_PIXELS))
        self._config, self._rows, self._columns = config, *pixels[::step].T
        turn = (np.arctan2(points[::step, 1], points[::step, 0]) + np.pi) / (2.0 * np.pi)
        self._sectors = (turn * _NUM_SECTORS).astype(int) % _NUM_SECTORS
        self._in_sector = np.bincount(self._sectors, minlength=_NUM_SECTORS)
        self.color, self.support, self.reason = color, 0.0, "no image yet"
        self._seen_ns: int | None = None
        self._period_ns = int(1e9 * config.look_s)
        self._other_since_ns: int | None = None
        self._num_other = 0
        self._whole = color  # as the whole ring showed it last

    def forget(self) -> None:
        """Forget how much time has passed: stamps jumped back."""
        self._seen_ns = self._other_since_ns = None

    def update(self, image: np.ndarray, order: str, stamp_ns: int) -> bool:
        """Look at an image.

        Args:
            image: (H, W, 3), uint8.
            order: Of its channels: `rgb` or `bgr`.
            stamp_ns: When it was taken.

        Returns:
            Whether the color changed.
        """
        if self._seen_ns is not None and 0 <= stamp_ns - self._seen_ns < self._period_ns:
            return False
        if self.color is None:
            self._seen_ns = stamp_ns
            return self._learn_first(image, order)
        colors = _rgb(image[self._rows, self._columns], order)
        dt = 0.0 if self._seen_ns is None else 1e-9 * (stamp_ns - self._seen_ns)
        self._seen_ns = stamp_ns
        is_floor = has_color(self.color, colors, self._config)
        self.support = self._support_of(is_floor)
        if self.support >= self._config.ring_share:
            self._other_since_ns, self.reason = None, ""
            return self._follow(colors, is_floor, dt)
        self.reason = f"only {self.support:.0%} of the ring around the robot has the floor's color"
        return self._relearn(colors, stamp_ns)

    def _follow(self, colors: np.ndarray, is_floor: np.ndarray, dt: float) -> bool:
        part = response_part(dt, self._config.adapt_s)
        if part == 0.0 or self.color is None or self._whole is None:
            return False
        total = colors.sum(axis=1, dtype=float)
        low, high = self.color.low / _ALIKE, self.color.high * _ALIKE
        is_shown = is_floor & (total >= low) & (total <= high)
        share = self._support_of(is_shown)
        if share < self._config.relearn_share:
            is_even = is_floor & self._is_even(total, is_floor)
            share_even = self._support_of(is_even)
            if share_even >= self._config.relearn_share:
                is_shown, share = is_even, share_even
        if share < self._config.ring_share or is_shown.sum() < _MIN_PIXELS:
            self.reason = f"only {share:.0%} of the ring is as bright as the floor was"
            return False
        new = followed(self.color, colors[is_shown], part)
        is_whole = share >= self._config.relearn_share
        if not is_whole and not is_near(self._whole, new):
            self.reason = f"the light changes, but only {share:.0%} of the ring shows the floor"
            return False
        self.color = new
        self._whole = new if is_whole else self._whole
        return True

    def _is_even(self, total: np.ndarray, is_floor: np.ndarray) -> np.ndarray:
        """Return which pixels are about as bright as most of the floor-colored ones."""
        middle = np.median(total[is_floor])
        return np.asarray((total >= middle / _ALIKE) & (total <= middle * _ALIKE))

    def _relearn(self, colors: np.ndarray, stamp_ns: int) -> bool:
        """Learn anew once nearly all of the ring has shared another color for long enough."""
        if self._config.relearn_s == 0.0 or not self._shares_one(colors):
            self._other_since_ns = None
            return False
        if self._other_since_ns is None:
            self._other_since_ns, self._num_other = stamp_ns, 0
        self._num_other += 1
        waited = 1e-9 * (stamp_ns - self._other_since_ns)
        if waited < self._config.relearn_s or self._num_other < self._config.relearn_looks:
            return False
        self._adopt(learn(colors, self._config), colors)
        return True

    def _shares_one(self, colors: np.ndarray) -> bool:
        try:
            other = learn(colors, self._config)
        except ValueError:
            return False
        share = self._support_of(has_color(other, colors, self._config))
        return share >= self._config.relearn_share

    def _learn_first(self, image: np.ndarray, order: str) -> bool:
        colors = _rgb(image[*self._first_pixels.T], order)
        bearings = np.arctan2(self._first_points[:, 1], self._first_points[:, 0])
        distances = np.hypot(*self._first_points.T)
        try:
            color = learn_first(colors, bearings, distances, self._config)
        except ValueError as error:
            self.reason = f"the floor's color is not known: {error}"
            return False
        self._adopt(color, _rgb(image[self._rows, self._columns], order))
        return True

    def _adopt(self, color: FloorColor, colors: np.ndarray) -> None:
        self.color = self._whole = color
        self.support = self._support_of(has_color(color, colors, self._config))
        self._other_since_ns, self.reason = None, ""

    def _support_of(self, is_floor: np.ndarray) -> float:
        """Return the share of directions half of whose pixels are floor."""
        floor = np.bincount(self._sectors, is_floor, minlength=_NUM_SECTORS)
        is_looked_at = self._in_sector > 0
        is_floor_there = floor >= _SECTOR_SHARE * self._in_sector
        return float(is_floor_there[is_looked_at].mean()) if is_looked_at.any() else 0.0


def _rgb(colors: np.ndarray, order: str) -> np.ndarray:
    return colors if order == "rgb" else colors[:, ::-1]
