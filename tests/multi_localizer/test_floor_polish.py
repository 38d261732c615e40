"""How much neighbors on the border err together: known answers, and independence."""

from __future__ import annotations

import numpy as np
import pytest

from multi_localizer.floor_kernels import NUM_VALUES
from multi_localizer.floor_polish import BLOCK, MOST_TOGETHER, togetherness

NUM_BLOCKS = 12


def rows_of(off: np.ndarray) -> np.ndarray:
    """Return pieces of two walls, one after the other, so far off their walls."""
    rows = np.zeros((len(off), NUM_VALUES))
    rows[:, 0] = off
    rows[len(off) // 2 :, 4] = 1.0
    return rows


def together(off: np.ndarray, weights: np.ndarray | None = None) -> float:
    ones = np.ones(len(off))
    return float(togetherness(rows_of(off), ones if weights is None else weights, 2))


def test_blocks_that_err_as_one_vary_as_much_as_their_pieces() -> None:
    signs = np.tile([1.0, -1.0], NUM_BLOCKS // 2)
    assert together(np.repeat(signs, BLOCK)) == pytest.approx(min(BLOCK, MOST_TOGETHER))
    halves = np.repeat(np.tile([1.0, -1.0], NUM_BLOCKS), BLOCK // 2)
    assert together(halves) == 1.0  # the halves of each block cancel


def test_half_as_one_and_half_alone_is_half_of_it() -> None:
    """Of two independent parts of like size the shared one counts `BLOCK` times, the other 0."""
    shared = np.repeat(np.tile([1.0, -1.0], NUM_BLOCKS // 2), BLOCK)
    alone = np.tile([1.0, -1.0], NUM_BLOCKS * BLOCK // 2)
    assert together(shared + alone) == pytest.approx(min(0.5 * BLOCK, MOST_TOGETHER))


def test_independent_pieces_err_not_together() -> None:
    rng = np.random.default_rng(0)
    found = [together(rng.normal(0.0, 0.3, 200 * BLOCK)) for _ in range(20)]
    assert np.mean(found) < 1.15 and min(found) >= 1.0


def test_a_wall_that_lies_off_as_a_whole_is_not_togetherness() -> None:
    rng = np.random.default_rng(1)
    off = rng.normal(0.0, 0.3, NUM_BLOCKS * BLOCK)
    shifted = off + 5.0 * (np.arange(len(off)) >= len(off) // 2)
    assert together(shifted) == pytest.approx(together(off))


def test_what_has_no_weight_says_nothing() -> None:
    rng = np.random.default_rng(2)
    off = rng.normal(0.0, 0.3, NUM_BLOCKS * BLOCK)
    weights = (np.arange(len(off)) % 3 > 0).astype(float)
    spoilt = np.where(weights > 0.0, off, 1e3)
    assert together(spoilt, weights) == together(off, weights)
    assert together(off, np.zeros(len(off))) == 1.0
