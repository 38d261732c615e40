"""The tree of frames over time: tf2's buffer, in plain Python for homes with and without tf2.

Behaves as tf2's documentation says: ten seconds of samples a frame, linear and spherical
interpolation, no extrapolation, static transforms valid at any stamp, stamp 0 means the newest
common one. It differs in four points: a repeated stamp replaces its sample without a warning,
a frame id may start with '/' when looked up as well, a loop is refused when it arrives, not when
it is walked, and nothing ever blocks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from floornav_common.transform3 import Transform3, invert
from floornav_common.transform_errors import (
    FutureExtrapolationError,
    NotConnectedError,
    PastExtrapolationError,
    TooEarlyError,
    TransformUnavailable,
    UnknownFrameError,
)
from floornav_common.transform_history import History, Sample

__all__ = [
    "FutureExtrapolationError", "NotConnectedError", "PastExtrapolationError", "TooEarlyError",
    "TransformBuffer", "TransformUnavailable", "UnknownFrameError", "clean_frame",
]  # fmt: skip

DEFAULT_CACHE_NS = 10_000_000_000
QUAT_NORM_TOLERANCE = 1e-2  # of the squared norm, as tf2


class TransformBuffer:
    """Stamped transforms between frames, looked up at any stamp they cover.

    Args:
        cache_ns: How long samples are kept behind the newest of their frame, ns.
    """

    def __init__(self, cache_ns: int = DEFAULT_CACHE_NS) -> None:
        """Start without frames."""
        self._cache_ns = cache_ns
        self._histories: dict[str, History] = {}
        self._frames: dict[str, None] = {}

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames heard of, in the order they came."""
        return tuple(self._frames)

    def set_transform(
        self,
        parent: str,
        child: str,
        stamp_ns: int,
        translation_xyz: Sequence[float],
        quat_xyzw: Sequence[float],
        is_static: bool = False,
    ) -> bool:
        """Store `T_parent_child` of a stamp; of equal stamps the last one counts.

        Args:
            parent: Frame the transform is given in; it may change from sample to sample.
            child: Frame that moves.
            stamp_ns: When it was so, ns; without meaning for a static one.
            translation_xyz: m.
            quat_xyzw: Rotation, normalised to within 1 % as tf2 wants it.
            is_static: Whether it is valid at any time. The last word counts.

        Returns:
            False if it was ignored for being older than the cache.

        Raises:
            ValueError: If a frame id is empty, frames form a loop, or a number is not usable.
        """
        parent, child = clean_frame(parent), clean_frame(child)
        sample = _checked_sample(parent, child, translation_xyz, quat_xyzw)
        self._refuse_loop(parent, child)
        history = self._histories.get(child)
        if history is None or history.is_static != is_static:
            history = self._histories[child] = History(is_static)
        self._frames.setdefault(parent)
        self._frames.setdefault(child)
        return history.insert(stamp_ns, sample, self._cache_ns)

    def lookup(self, target: str, source: str, stamp_ns: int | None = None) -> Transform3:
        """Return `T_target_source`: what takes points of `source` to `target` at a stamp.

        Args:
            target: Frame to come out in.
            source: Frame of the data.
            stamp_ns: When, ns; 0 or None for the newest stamp known of the whole chain.

        Raises:
            TransformUnavailable: By kind, see `transform_errors`.
        """
        target, source = self._known(target), self._known(source)
        if target == source:
            return Transform3.identity()
        stamp = stamp_ns or self.newest_common_stamp(target, source)
        up, down = self._chains(target, source, stamp)
        return Transform3(invert(self._product(up, stamp)) @ self._product(down, stamp))

    def can_transform(self, target: str, source: str, stamp_ns: int | None = None) -> bool:
        """Return whether `lookup` would answer."""
        try:
            self.lookup(target, source, stamp_ns)
        except TransformUnavailable:
            return False
        return True

    def newest_common_stamp(self, target: str, source: str) -> int:
        """Return the newest stamp all moving frames between two have reached; 0 if none moves.

        Raises:
            TransformUnavailable: If a frame is unknown or they are not connected.
        """
        target, source = self._known(target), self._known(source)
        up, down = self._join(target, source, lambda frame: self._histories[frame].newest_parent)
        chain = [self._histories[frame] for frame in up + down]
        return min((h.newest_stamp_ns for h in chain if not h.is_static), default=0)

    def parent_of(self, child: str) -> str | None:
        """Return the newest parent of a frame; None for a root or an unknown frame."""
        history = self._histories.get(clean_frame(child))
        return None if history is None else history.newest_parent

    def clear(self) -> None:
        """Forget all that moves, as when the clock jumps back; static transforms stay."""
        self._histories = {child: h for child, h in self._histories.items() if h.is_static}

    def _known(self, frame: str) -> str:
        name = clean_frame(frame)
        if name not in self._frames:
            known = ", ".join(sorted(self._frames)) or "none"
            raise UnknownFrameError(f"frame '{name}' is not in the transform tree (known: {known})")
        return name

    def _chains(self, target: str, source: str, stamp_ns: int) -> tuple[list[str], list[str]]:
        stopped: list[str] = []

        def parent_at(frame: str) -> str | None:
            history = self._histories[frame]
            if history.covers(stamp_ns):
                return history.parent_at(stamp_ns)
            stopped.append(frame)
            return None

        try:
            return self._join(target, source, parent_at)
        except NotConnectedError as error:
            if not stopped:
                raise
            raise self._extrapolation(target, source, stopped, stamp_ns) from error

    def _join(
        self, target: str, source: str, parent_of: Callable[[str], str | None]
    ) -> tuple[list[str], list[str]]:
        """Return the frames passed from `target` and from `source` up to where they meet."""
        down = self._climb(source, parent_of, {target: 0})
        meets = {frame: i for i, frame in enumerate(down)}
        up = self._climb(target, parent_of, meets)
        if up[-1] not in meets:
            raise NotConnectedError(
                f"no chain of transforms joins '{source}' to '{target}': "
                f"'{source}' hangs below '{down[-1]}', '{target}' below '{up[-1]}'"
            )
        return up[:-1], down[: meets[up[-1]]]

    def _climb(
        self, frame: str, parent_of: Callable[[str], str | None], until: dict[str, int]
    ) -> list[str]:
        chain = [frame]
        while chain[-1] not in until and chain[-1] in self._histories:
            parent = parent_of(chain[-1])
            if parent is None or len(chain) > len(self._frames):
                break
            chain.append(parent)
        return chain

    def _product(self, chain: list[str], stamp_ns: int) -> np.ndarray:
        matrix = np.eye(4)
        for frame in chain:
            matrix = self._histories[frame].matrix_at(stamp_ns) @ matrix
        return matrix

    def _extrapolation(
        self, target: str, source: str, stopped: list[str], stamp_ns: int
    ) -> TransformUnavailable:
        past = [f for f in stopped if stamp_ns < self._histories[f].oldest_stamp_ns]
        frame = (past or stopped)[0]
        history = self._histories[frame]
        oldest, newest = history.oldest_stamp_ns, history.newest_stamp_ns
        text = (
            f"'{source}' to '{target}' at {_seconds(stamp_ns)}: '{history.newest_parent}' to "
            f"'{frame}' is only known from {_seconds(oldest)} to {_seconds(newest)}"
        )
        if not past:
            return FutureExtrapolationError(text)
        is_gone = stamp_ns < newest - self._cache_ns
        return TooEarlyError(text) if is_gone else PastExtrapolationError(text)

    def _refuse_loop(self, parent: str, child: str) -> None:
        above, frame = [parent], parent
        while frame != child and frame in self._histories and len(above) <= len(self._frames):
            frame = self._histories[frame].newest_parent
            above.append(frame)
        if frame == child:
            raise ValueError(f"frames form a loop: {' -> '.join([child, *above])}")


def clean_frame(frame: str) -> str:
    """Return a frame id without the leading '/' that tf1 wrote.

    Raises:
        ValueError: If nothing is left.
    """
    name = frame[1:] if frame.startswith("/") else frame
    if not name:
        raise ValueError(f"frame id must not be empty, got {frame!r}")
    return name


def _checked_sample(
    parent: str, child: str, translation_xyz: Sequence[float], quat_xyzw: Sequence[float]
) -> Sample:
    x, y, z, w = (float(v) for v in quat_xyzw)
    translation = np.array(translation_xyz, dtype=float)
    squared = x * x + y * y + z * z + w * w
    if translation.shape != (3,) or not math.isfinite(float(translation.sum())):
        raise ValueError(f"translation of '{parent}' to '{child}' is not usable: {translation}")
    if not abs(squared - 1.0) <= QUAT_NORM_TOLERANCE:
        raise ValueError(
            f"rotation of '{parent}' to '{child}' is not a unit quaternion: {(x, y, z, w)}"
        )
    return Sample(parent, translation, np.array((x, y, z, w)))


def _seconds(stamp_ns: int) -> str:
    return f"{stamp_ns // 1_000_000_000}.{stamp_ns % 1_000_000_000:09d}"
