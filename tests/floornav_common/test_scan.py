"""Scans: which beams are measurements (REP 117), and where their points are."""

import math

import numpy as np
import pytest

from floornav_common.scan import Scan

NAN, INF = math.nan, math.inf


def test_points_lie_where_the_beams_point():
    scan = Scan(np.array([1.0, 2.0, 3.0]), -math.pi / 2.0, math.pi / 2.0, 0.1, 10.0)
    assert scan.points() == pytest.approx(np.array([[0.0, -1.0], [2.0, 0.0], [0.0, 3.0]]), abs=1e-9)


@pytest.mark.parametrize(
    ("value", "is_hit"),
    [(1.0, True), (0.5, True), (10.0, True), (0.49, False), (10.1, False), (0.0, False),
     (-1.0, False), (NAN, False), (INF, False), (-INF, False)],
)  # fmt: skip
def test_only_ranges_within_the_limits_are_hits(value, is_hit):
    scan = Scan(np.array([value]), 0.0, 0.1, 0.5, 10.0)
    assert scan.is_hit.tolist() == [is_hit]
    assert len(scan.points()) == is_hit


def test_a_limit_of_infinity_does_not_make_infinity_a_hit():
    assert not Scan(np.array([INF]), 0.0, 0.1, 0.0, INF).is_hit.any()
