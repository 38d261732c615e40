"""Which way a pane lies that sonars hear from several places.

One echo says how far off a pane is and not which way it lies: a sonar hears it up to its opening
and what glass scatters beside the mirror's way. But all echoes of one pane are as far off as their
sonars are from one line, so each direction within the cone is asked how many echoes agree on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2

_WIDEST = np.deg2rad(26.0)  # off the sonar's axis: half an opening, and a smooth wall's own cone
_TILTS = np.linspace(-_WIDEST, _WIDEST, 27)
_SLACK = 0.04  # an echo this far off a line says nothing for it, m
_COST = 1.0  # of the widest tilt, in echoes: without others it is across the axis


@dataclass(frozen=True)
class PaneLine:
    """The line that an echo came from.

    Attributes:
        tilt: By how much its normal is turned from the sonar's axis, rad.
        num_others: How many other echoes came from it.
    """

    tilt: float = 0.0
    num_others: int = 0


def pane_line(r: float, T_base_sonar: SE2, places: np.ndarray, ranges: np.ndarray) -> PaneLine:
    """Return the line that most echoes agree on with this one.

    Args:
        r: How far off the sonar hears it, m.
        T_base_sonar: The sonar, which looks along its x axis.
        places: Where sonars were that heard something lately, in the base frame, shape (N, 2), m.
        ranges: How far off, shape (N,), m.
    """
    angles = T_base_sonar.yaw + _TILTS
    normals = np.stack((np.cos(angles), np.sin(angles)))
    away = (places - np.array([T_base_sonar.x, T_base_sonar.y])) @ normals
    off = (away + ranges[:, None] - r) / _SLACK
    score = np.maximum(1.0 - off * off, 0.0).sum(axis=0) - _COST * (_TILTS / _WIDEST) ** 2
    best = int(np.argmax(score))
    return PaneLine(float(_TILTS[best]), int((np.abs(off[:, best]) < 1.0).sum()))
