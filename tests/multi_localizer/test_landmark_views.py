"""Bearings of several sensors at one place, brought together."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.landmark_views import turned_together


def test_bearings_are_turned_into_the_common_frame() -> None:
    views = {
        "a": (np.array([0.1, math.nan]), SE2(0.2, 0.0, 0.0)),
        "b": (np.array([0.3]), SE2(0.2, 0.0, -0.5)),
    }
    together = turned_together(views, SE2(0.2, 0.0, 1.0))
    assert together["a"][0] == pytest.approx(-0.9) and math.isnan(together["a"][1])
    assert together["b"] == pytest.approx([-1.2])
    assert views["b"][0][0] == 0.3


def test_bearings_from_another_place_are_refused() -> None:
    views = {"a": (np.zeros(1), SE2(0.0, 0.3, 0.0))}
    with pytest.raises(ValueError, match="bearings of a are seen from 0.30 m beside"):
        turned_together(views, SE2.identity())
