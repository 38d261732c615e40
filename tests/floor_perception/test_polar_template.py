"""Templates: which pixel belongs to which cell."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from painted_floors import upright_camera

from floor_perception.config import TemplateConfig
from floor_perception.free_space import floor_areas, ratios_and_ranges
from floor_perception.polar_template import cells_of, is_border, make_template, ring_edges

PAPER = TemplateConfig(num_rings=6, num_directions=32, has_borders=True)


def test_a_point_straight_ahead_lies_in_the_middle_direction() -> None:
    edges = np.array([1.0, 2.0, 3.0])
    points = np.array([[1.5, 0.0], [2.5, 0.0], [0.0, 1.5], [-1.5, 0.0], [0.5, 0.0], [9.0, 0.0]])
    assert cells_of(points, edges, 4).tolist() == [4, 5, 6, 0, -1, -1]


def test_a_direction_reaches_half_a_step_to_both_sides() -> None:
    edges = np.array([1.0, 2.0])
    half = math.pi / 8
    angles = np.array([-half + 1e-6, half - 1e-6, half + 1e-6])
    points = 1.5 * np.stack((np.cos(angles), np.sin(angles)), -1)
    assert cells_of(points, edges, 8).tolist() == [4, 4, 5]


def test_points_above_the_horizon_or_unseen_lie_in_no_cell() -> None:
    points = np.array([[np.inf, np.inf], [np.nan, np.nan]])
    assert cells_of(points, np.array([1.0, 2.0]), 4).tolist() == [-1, -1]


def test_rings_of_equal_image_radius_are_so_in_the_image() -> None:
    camera = upright_camera()
    edges = ring_edges(camera, PAPER)
    radii = camera.camera.image_radius(-np.arctan2(camera.height_m, edges))
    assert np.diff(radii) == pytest.approx(np.full(6, (radii[-1] - radii[0]) / 6), abs=0.02)


def test_rings_of_equal_distance_are_so_on_the_floor() -> None:
    edges = ring_edges(upright_camera(), replace(PAPER, spacing="floor"))
    assert np.diff(edges) == pytest.approx(np.full(6, (2.5 - 0.17) / 6))


@pytest.mark.parametrize("size", [(256, 220), (640, 480)])
def test_every_cell_of_the_default_can_decide(size: tuple[int, int]) -> None:
    template = make_template(upright_camera(size), TemplateConfig())
    assert (template.stand_ins >= 0).all()
    assert (template.areas[template.stand_ins] > 0).all()
    assert template.areas.sum() == (template.cells >= 0).sum()


def test_a_cell_too_small_for_a_pixel_is_decided_by_the_one_its_middle_lies_in() -> None:
    camera = upright_camera()
    template = make_template(camera, TemplateConfig(num_directions=360))
    (empty,) = np.nonzero(template.areas == 0)
    assert len(empty) > 100
    middles = 0.5 * (template.edges[:-1] + template.edges[1:])
    r, bearing = middles[empty % 36], template.bearings[empty // 36]
    points = np.stack((r * np.cos(bearing), r * np.sin(bearing)), -1)
    u, v = np.rint(camera.floor_pixels(points)).astype(int).T
    assert (template.stand_ins[empty] == template.cells[v, u]).all()
    whole = np.nonzero(template.areas > 0)[0]
    assert (template.stand_ins[whole] == whole).all()


def test_spans_hold_every_pixel_of_a_cell_and_no_more() -> None:
    template = make_template(upright_camera(), PAPER)
    for row, (first, past) in zip(template.cells, template.spans, strict=True):
        (used,) = np.nonzero(row >= 0)
        assert (first, past) == ((used[0], used[-1] + 1) if len(used) else (0, 0))


def test_border_lines_keep_cells_from_touching() -> None:
    camera = upright_camera()
    lined = make_template(camera, PAPER)
    assert not is_border(lined.cells.astype(np.int32)).any()
    whole = make_template(camera, replace(PAPER, has_borders=False))
    assert is_border(whole.cells.astype(np.int32)).any()
    assert 0.7 < lined.areas.sum() / whole.areas.sum() < 0.95


def test_hidden_pixels_belong_to_no_cell() -> None:
    camera = upright_camera()
    is_hidden = np.zeros((220, 256), dtype=bool)
    is_hidden[:, 128:] = True
    template = make_template(camera, TemplateConfig(), is_hidden)
    assert (template.cells[:, 128:] == -1).all()
    ahead = template.num_directions // 2 * template.num_rings
    assert (template.stand_ins[ahead : ahead + template.num_rings] == -1).all()


def test_cells_outside_an_image_that_cuts_the_template_are_not_seen() -> None:
    """The mirror's lower part, a robot's left, is not in the picture: nor are its cells."""
    camera = upright_camera()
    cut = replace(camera, camera=replace(camera.camera, height_px=180))
    template = make_template(cut, TemplateConfig())
    left = 3 * template.num_directions // 4
    cells = slice(left * template.num_rings, (left + 1) * template.num_rings)
    distance = 0.5 * (template.edges[:-1] + template.edges[1:])
    pixels = camera.floor_pixels(np.stack((np.zeros_like(distance), distance), -1))
    is_cut = pixels[:, 1] > 181.0
    assert is_cut.sum() > 10 and (~is_cut).sum() > 5
    assert (template.stand_ins[cells][is_cut] == -1).all()
    floor = np.full((180, 256), 255, dtype=np.uint8)
    _, ranges = ratios_and_ranges(floor_areas(floor, template), template, 0.6)
    assert np.isnan(ranges[left]) and np.isposinf(ranges[template.num_directions // 4])


def test_a_hidden_mask_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="hidden mask must be"):
        make_template(upright_camera(), PAPER, np.zeros((2, 2), dtype=bool))


def test_a_horizon_that_the_camera_does_not_see_is_refused() -> None:
    with pytest.raises(ValueError, match="must see the floor"):
        make_template(upright_camera(), replace(PAPER, horizon_m=50.0))


def test_turning_the_camera_turns_the_directions() -> None:
    camera = upright_camera()
    quarter = replace(camera, yaw_rad=math.pi / 2)
    plain, turned = (make_template(c, PAPER) for c in (camera, quarter))
    both = (plain.cells >= 0) & (turned.cells >= 0)
    ways = (turned.cells[both] // 6 - plain.cells[both] // 6) % 32
    assert (ways == 8).mean() > 0.999
