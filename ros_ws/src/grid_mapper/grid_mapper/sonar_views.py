"""What sonars heard, kept by where they were and looked: the newest word of every view.

A view is a place (a few cm) and a direction (a few degrees). A reading again from the same view is
integrated: one that agrees adds to the view's weight and to the mean of its range, one that does
not takes from it and in the end replaces it. So neither a robot that stands still nor a fast sonar
counts more, memory grows with the ways driven and not with time, and what moved away is forgotten
where one looks again.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floornav_common.se2 import SE2

NEAR_M = 0.8
"""Edge of the cells that neighboring views are found by."""
END = -1
PIECE = 2000
SAME_ECHO_M, SAME_ECHO_SHARE = 0.05, 0.02
"""An echo heard again differs by no more: the place within a view differs too."""
VIEW = np.dtype(
    [
        ("x", "f8"), ("y", "f8"), ("yaw", "f8"), ("half", "f8"), ("r", "f8"), ("weight", "f8"),
        ("theta", "f8"), ("score", "f8"), ("open", "i8"), ("stamp_ns", "i8"), ("next", "i8"),
        ("is_echo", "?"),
    ],
    align=True,
)  # fmt: skip
"""A view: pose of the sonar in the map (m, rad), half its cone's opening (rad), range of the echo
or free length without one (m), how often it was so, and when (ns) last; then what `echo_judging`
says of it; `next` is the row of another view in the same cell of `NEAR_M`."""


class SonarViews:
    """Rows of views.

    Attributes:
        num: Views held.
        rows: Shape (>= num,), of `VIEW`.
    """

    def __init__(self, view_m: float, view_rad: float, max_views: int) -> None:
        self._view_m, self._view_rad, self._max_views = view_m, view_rad, max_views
        self._row_of: dict[tuple[int, int, int], int] = {}
        self._keys: list[tuple[int, int, int]] = []
        self._first: dict[tuple[int, int], int] = {}
        self.num = 0
        self.rows = np.zeros(256, VIEW)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled: keys as arrays, which are read back without holding all up."""
        state = dict(vars(self), _keys=np.array(self._keys, np.int64).reshape(-1, 3))
        del state["_row_of"]
        cells = np.array(list(self._first), np.int64).reshape(-1, 2)
        return state | {"_first": (cells, np.array(list(self._first.values()), np.int64))}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what was pickled, a piece at a time: other threads go on meanwhile."""
        cells, rows = state.pop("_first")
        keys = state.pop("_keys")
        vars(self).update(state, _keys=[], _row_of={}, _first={})
        for k in range(0, len(keys), PIECE):
            piece = list(map(tuple, keys[k : k + PIECE].tolist()))
            self._row_of.update(zip(piece, range(k, k + len(piece)), strict=True))
            self._keys += piece
        for k in range(0, len(cells), PIECE):
            piece = list(map(tuple, cells[k : k + PIECE].tolist()))
            self._first.update(zip(piece, rows[k : k + PIECE].tolist(), strict=True))

    @property
    def used(self) -> np.ndarray:
        """The rows in use."""
        return self.rows[: self.num]

    @property
    def num_bytes(self) -> int:
        """Bytes held by the rows."""
        return self.rows.nbytes

    def add(
        self, pose: SE2, half: float, r: float, is_echo: bool, stamp_ns: int, max_weight: float
    ) -> int:
        """Integrate a reading and return the row of its view.

        Args:
            pose: Of the sonar in the map, which looks along its x axis.
            half: Half the opening of its cone, rad.
            r: Range of the echo, or the free length, m.
            is_echo: Whether there was an echo.
            stamp_ns: Of the reading.
            max_weight: A view weighs no more.
        """
        key = self._key(pose)
        row = self._row_of.get(key, END)
        weight = 1.0
        if row == END:
            row = self._new_row(key)
        else:
            held = self.rows[row]
            old = float(held["weight"])
            if _agrees(held, r, is_echo):
                share, weight = 1.0 / (old + 1.0), min(old + 1.0, max_weight)
                pose = SE2(float(held["x"]), float(held["y"]), float(held["yaw"])).interpolate(
                    pose, share
                )
                r = float(held["r"]) + share * (r - float(held["r"]))
            elif old > 1.0:
                held["weight"] = old - 1.0
                return row
        place = (pose.x, pose.y, pose.yaw, half, r, weight, 0.0, 0.0, 0, stamp_ns)
        self.rows[row] = (*place, self.rows[row]["next"], is_echo)
        return row

    def near(self, row: int) -> np.ndarray:
        """Return the first rows of the cells about a view's, for walks along `next`, shape (9,)."""
        col, line = self._cell(self._keys[row])
        around = (-1, 0, 1)
        firsts = [self._first.get((col + i, line + j), END) for i in around for j in around]
        return np.array(firsts, np.int64)

    def _key(self, pose: SE2) -> tuple[int, int, int]:
        turns = round(2.0 * math.pi / self._view_rad)
        direction = math.floor(pose.yaw / self._view_rad) % turns
        return math.floor(pose.x / self._view_m), math.floor(pose.y / self._view_m), direction

    def _cell(self, key: tuple[int, int, int]) -> tuple[int, int]:
        scale = self._view_m / NEAR_M
        return math.floor((key[0] + 0.5) * scale), math.floor((key[1] + 0.5) * scale)

    def _new_row(self, key: tuple[int, int, int]) -> int:
        if self.num < self._max_views:
            row = self.num
            self.num += 1
            self._keys.append(key)
            if self.num > len(self.rows):
                grown = np.zeros(len(self.rows) * 3 // 2, VIEW)
                grown[:row] = self.rows
                self.rows = grown
        else:
            row = int(np.argmin(self.used["stamp_ns"]))
            self._unlink(row)
            self._keys[row] = key
        self._row_of[key] = row
        cell = self._cell(key)
        self.rows[row]["next"] = self._first.get(cell, END)
        self._first[cell] = row
        return row

    def _unlink(self, row: int) -> None:
        """Take a view out, so that its row can be used again."""
        key, after = self._keys[row], int(self.rows[row]["next"])
        del self._row_of[key]
        cell = self._cell(key)
        before = self._first[cell]
        if before == row:
            self._first[cell] = after
            return
        while self.rows[before]["next"] != row:
            before = int(self.rows[before]["next"])
        self.rows[before]["next"] = after


def _agrees(held: np.void, r: float, is_echo: bool) -> bool:
    if not is_echo or not held["is_echo"]:
        return bool(is_echo == held["is_echo"])
    return bool(abs(r - held["r"]) <= SAME_ECHO_M + SAME_ECHO_SHARE * r)
