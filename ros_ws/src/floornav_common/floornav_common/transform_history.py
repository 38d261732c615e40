"""What is known of one frame over time: stamped transforms to its parent, interpolated as tf2 does.

tf2 keeps a list of samples a child frame, ten seconds long, each with its parent; between two
samples of one parent the translation moves on a line and the rotation on the shorter great arc.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right

import numpy as np
from scipy.spatial.transform import Rotation

from floornav_common.transform3 import homogeneous


class Sample:
    """One stamped transform `T_parent_child`; the rotation is only worked out when asked for."""

    __slots__ = ("_matrix", "_quat_xyzw", "_rotation", "_turn", "_turn_to", "parent", "translation")

    def __init__(self, parent: str, translation: np.ndarray, quat_xyzw: np.ndarray) -> None:
        """Keep a translation (3,), m, and a unit quaternion (4,)."""
        self.parent = parent
        self.translation = translation
        self._quat_xyzw = quat_xyzw
        self._rotation: Rotation | None = None
        self._matrix: np.ndarray | None = None
        self._turn_to: Sample | None = None
        self._turn = np.zeros(3)

    @property
    def rotation(self) -> Rotation:
        """Orientation of the child in its parent."""
        if self._rotation is None:
            self._rotation = Rotation.from_quat(self._quat_xyzw)
        return self._rotation

    @property
    def matrix(self) -> np.ndarray:
        """`T_parent_child`, shape (4, 4)."""
        if self._matrix is None:
            self._matrix = homogeneous(self.rotation.as_matrix(), self.translation)
        return self._matrix

    def between(self, later: Sample, share: float) -> np.ndarray:
        """Return the (4, 4) matrix `share` (0..1) of the way to a later sample of the parent."""
        if self._turn_to is not later:
            self._turn = (self.rotation.inv() * later.rotation).as_rotvec()
            self._turn_to = later
        part = Rotation.from_rotvec(share * self._turn).as_matrix()
        translation = (1.0 - share) * self.translation + share * later.translation
        return homogeneous(self.matrix[:3, :3] @ part, translation)


class History:
    """The samples of one child frame in stamp order; a static one has only one.

    Args:
        is_static: Whether the frame came on `/tf_static`.
    """

    def __init__(self, is_static: bool) -> None:
        """Start empty."""
        self.is_static = is_static
        self._stamps: list[int] = []
        self._samples: list[Sample] = []

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self._samples)

    @property
    def oldest_stamp_ns(self) -> int:
        """Stamp of the first sample kept."""
        return self._stamps[0]

    @property
    def newest_stamp_ns(self) -> int:
        """Stamp of the last sample."""
        return self._stamps[-1]

    @property
    def newest_parent(self) -> str:
        """Parent in the last sample."""
        return self._samples[-1].parent

    def insert(self, stamp_ns: int, sample: Sample, cache_ns: int) -> bool:
        """Add a sample; one of the same stamp is replaced. False if older than the cache."""
        if self.is_static:
            self._stamps, self._samples = [stamp_ns], [sample]
            return True
        if self._stamps and stamp_ns < self._stamps[-1] - cache_ns:
            return False
        at = bisect_left(self._stamps, stamp_ns)
        if at < len(self._stamps) and self._stamps[at] == stamp_ns:
            self._samples[at] = sample
        else:
            self._stamps.insert(at, stamp_ns)
            self._samples.insert(at, sample)
            self._forget_before(self._stamps[-1] - cache_ns)
        return True

    def covers(self, stamp_ns: int) -> bool:
        """Return whether the transform at a stamp is known without extrapolation."""
        if self.is_static:
            return True
        return self._stamps[0] <= stamp_ns <= self._stamps[-1]

    def parent_at(self, stamp_ns: int) -> str:
        """Return the parent at a covered stamp: that of the sample at or before it."""
        return self._samples[self._at_or_before(stamp_ns)].parent

    def matrix_at(self, stamp_ns: int) -> np.ndarray:
        """Return `T_parent_child` at a covered stamp, shape (4, 4)."""
        at = self._at_or_before(stamp_ns)
        sample = self._samples[at]
        if self.is_static or self._stamps[at] == stamp_ns:
            return sample.matrix
        later = self._samples[at + 1]
        if later.parent != sample.parent:
            return sample.matrix
        span = self._stamps[at + 1] - self._stamps[at]
        return sample.between(later, (stamp_ns - self._stamps[at]) / span)

    def _at_or_before(self, stamp_ns: int) -> int:
        return 0 if self.is_static else bisect_right(self._stamps, stamp_ns) - 1

    def _forget_before(self, stamp_ns: int) -> None:
        num_old = bisect_left(self._stamps, stamp_ns)
        if num_old:
            del self._stamps[:num_old], self._samples[:num_old]
