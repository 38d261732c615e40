"""Each rule that keeps a wrong pose from passing for a right one, by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from floor_masks import rectangle

from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_doubts import (
    MAX_BEYOND,
    MAX_OFFSET_SD,
    MAX_SD_M,
    MAX_SD_RAD,
    PolishedFit,
    doubt,
)

PLAN, CONFIG = rectangle(2.0, 1.0), FloorFitConfig()
GOOD = PolishedFit(
    pose=np.array([0.9, 0.4, 1.0]), cov=np.diag([0.01, 0.01, 0.01]) ** 2, sd_px=0.3, offset_px=0.5,
    hidden=0.3, beyond=0.02,
)  # fmt: skip


def test_nothing_speaks_against_a_good_fit():
    assert doubt(GOOD, PLAN, CONFIG) == ""


@pytest.mark.parametrize(
    ("key", "allowed", "refused", "word"),
    [
        ("pose", np.array([0.99, 0.4, 1.0]), np.array([1.01, 0.4, 1.0]), "outside"),
        ("hidden", CONFIG.max_hidden, CONFIG.max_hidden + 0.01, "show no wall"),
        ("beyond", MAX_BEYOND, MAX_BEYOND + 0.01, "no floor"),
        ("offset_px", MAX_OFFSET_SD, MAX_OFFSET_SD + 0.01, "inside the walls"),
        ("offset_px", -MAX_OFFSET_SD, -MAX_OFFSET_SD - 0.01, "inside the walls"),
        ("sd_px", CONFIG.max_sd_px - 0.01, CONFIG.max_sd_px, "scatters"),
        ("cov", np.diag([MAX_SD_M - 0.01, 0.1, 0.1]) ** 2,
         np.diag([MAX_SD_M + 0.01, 0.1, 0.1]) ** 2, "determine"),
        ("cov", np.diag([0.1, MAX_SD_M - 0.01, 0.1]) ** 2,
         np.diag([0.1, MAX_SD_M + 0.01, 0.1]) ** 2, "determine"),
        ("cov", np.diag([0.1, 0.1, MAX_SD_RAD - 0.01]) ** 2,
         np.diag([0.1, 0.1, MAX_SD_RAD + 0.01]) ** 2, "determine"),
    ],
)  # fmt: skip
def test_what_lies_past_a_limit_is_doubted_and_what_lies_before_is_not(key, allowed, refused, word):
    assert doubt(replace(GOOD, **{key: allowed}), PLAN, CONFIG) == ""
    assert word in doubt(replace(GOOD, **{key: refused}), PLAN, CONFIG)
