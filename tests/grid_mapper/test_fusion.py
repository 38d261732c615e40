"""Methods by name."""

import numpy as np
import pytest

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.bayes_fusion import BayesFusion
from grid_mapper.config import GridMapperConfig
from grid_mapper.fusion import make_fusion


def one_row(*cells):
    return OccupancyMap(np.array([cells], np.int8), 0.05, SE2.identity())


LASER, SONAR = one_row(FREE, FREE, UNKNOWN), one_row(OCCUPIED, FREE, OCCUPIED)


@pytest.mark.parametrize(
    ("name", "occupancy", "glass"),
    [("overlay", [OCCUPIED, FREE, UNKNOWN], [OCCUPIED, UNKNOWN, UNKNOWN]),
     ("none", [FREE, FREE, UNKNOWN], [UNKNOWN] * 3)],
)  # fmt: skip
def test_each_method_gives_its_map_and_its_glass(name, occupancy, glass):
    fusion = make_fusion(GridMapperConfig(fusion=name), lambda: LASER, lambda: SONAR)
    assert fusion.occupancy(LASER).cells.tolist() == [occupancy]
    assert fusion.glass().cells.tolist() == [glass]


def test_a_method_of_its_own_maps_keeps_the_lasers_lattice_and_knows_no_glass_at_first():
    fusion = make_fusion(GridMapperConfig(fusion="bayes"), lambda: LASER, lambda: SONAR)
    assert isinstance(fusion, BayesFusion)
    whole = fusion.occupancy(LASER)
    assert (whole.cells.tolist(), whole.origin) == (LASER.cells.tolist(), LASER.origin)
    assert not (fusion.glass().cells == OCCUPIED).any()
