"""The parameter file of the offline command."""

from __future__ import annotations

from pathlib import Path

import pytest

from grid_mapper.config_file import load_mapper_config

ROS_FILE = """
grid_mapper:
  ros__parameters:
    grid: log_odds
    motion: {slip: 0.2}
    label.noise_points: 7
    base_frame: base_footprint
    map_period_s: 2.0
"""


def _load(folder: Path, text: str):  # type: ignore[no-untyped-def]
    path = folder / "parameters.yaml"
    path.write_text(text)
    return load_mapper_config(path)


def test_values_of_groups_and_frames_are_taken(tmp_path: Path):
    mapper, frames = _load(tmp_path, ROS_FILE)
    assert (mapper.grid, mapper.motion.slip, mapper.label.noise_points) == ("log_odds", 0.2, 7)
    assert frames.base == "base_footprint"


def test_a_plain_mapping_does_as_well(tmp_path: Path):
    mapper, _ = _load(tmp_path, "matcher: {cell_m: 0.5}\n")
    assert mapper.matcher.cell_m == 0.5


def test_a_value_out_of_range_in_a_group_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match="slip must be >= 0"):
        _load(tmp_path, "motion: {slip: -1.0}\n")


def test_an_unknown_name_in_a_group_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match=r"'motion.slipp' \(did you mean 'motion.slip'\?\)"):
        _load(tmp_path, "motion: {slipp: 0.1}\n")


def test_a_wrong_value_of_the_node_itself_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match="map_mode must be one of"):
        _load(tmp_path, "map_mode: vector\n")
