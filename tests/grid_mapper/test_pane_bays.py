"""Bays between posts, by hand: `g` glass, `#` opaque, `o` found open, `w` weak, `.` nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grid_mapper.pane_bays import GLASS, NEUTRAL, OPAQUE, OPEN, WEAK, in_doubt

KINDS = {"g": GLASS, "#": OPAQUE, "o": OPEN, "w": WEAK, ".": NEUTRAL}
MAX_BAY, MAX_POST = 4, 2


def doubts(line: str) -> str:
    """Return the line with `?` where a bay is in doubt."""
    states = np.array([KINDS[c] for c in line])
    found = in_doubt(states, states == GLASS, MAX_BAY, MAX_POST)
    return "".join("?" if is_in else c for c, is_in in zip(line, found, strict=True))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("gg#...#...#", "gg#???#???#"),  # bay after bay
        ("#...#...#gg", "#???#???#gg"),  # either way
        ("gg#.ww#", "gg#???#"),  # beams or echoes that posts explain as well
        ("gg#.....#", "gg#.....#"),  # longer than a bay
        ("gg#...", "gg#..."),  # ends in the open
        ("gg#.o.#...#", "gg#.o.#...#"),  # found open, and what lies beyond it
        ("gg###...#", "gg###...#"),  # a wall
        ("gg#...###...#", "gg#???###...#"),  # up to a wall
        ("#...#...#", "#...#...#"),  # no glass there
    ],
)
def test_bays_that_follow_on_glass_are_in_doubt(line, expected):
    assert doubts(line) == expected


@given(st.text("g#ow.", min_size=1, max_size=40))
def test_only_what_nothing_is_known_of_is_in_doubt_and_both_ways_are_alike(line):
    found = doubts(line)
    assert all(b in (a, "?") and (a in "w." or b == a) for a, b in zip(line, found, strict=True))
    assert doubts(line[::-1]) == found[::-1]
