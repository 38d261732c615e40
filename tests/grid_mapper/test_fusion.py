"""Methods by name, and what is said where one is missing."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
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


def test_a_method_that_is_not_there_is_refused_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "grid_mapper.bayes_fusion", None)
    with pytest.raises(ValueError, match="fusion: bayes .* use overlay") as error:
        make_fusion(GridMapperConfig(fusion="bayes"), lambda: LASER, lambda: SONAR)
    assert "\n" not in str(error.value)


def test_the_bayesian_method_is_taken_from_its_module_with_the_configuration(monkeypatch):
    module = SimpleNamespace(BayesFusion=lambda config: ("made", config))
    monkeypatch.setitem(sys.modules, "grid_mapper.bayes_fusion", module)
    config = GridMapperConfig(fusion="bayes")
    assert make_fusion(config, lambda: LASER, lambda: SONAR) == ("made", config)
