"""What goes to a browser: pictures of maps, points, and JSON that every browser reads."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.live_view import encoding
from floornav_common.live_view.config import LiveViewConfig
from floornav_common.se2 import SE2


def decoded(data: bytes) -> np.ndarray:
    """Return a picture's pixels as they are."""
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


def test_a_map_becomes_a_grey_picture_with_its_last_row_on_top() -> None:
    cells = np.array([[-1, 0, 100], [50, -1, 0]], dtype=np.int8)
    grey = decoded(encoding.grid_png(cells))
    assert grey.tolist() == [[51, 0, 1], [0, 1, 101]]


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 40))
def test_a_map_comes_back_from_its_picture(seed: int, height: int, width: int) -> None:
    cells = np.random.default_rng(seed).integers(-1, 101, (height, width)).astype(np.int8)
    back = decoded(encoding.grid_png(cells))[::-1].astype(int) - 1
    assert np.array_equal(back, cells)


def test_cells_beyond_the_scale_count_as_its_ends() -> None:
    grey = decoded(encoding.grid_png(np.array([[-128, 127]], dtype=np.int8)))
    assert grey.tolist() == [[0, 101]]


def test_a_map_without_cells_is_refused() -> None:
    with pytest.raises(ValueError, match="map must have cells"):
        encoding.grid_png(np.zeros((0, 5), dtype=np.int8))


def test_a_binary_message_is_length_json_and_payload_on_four_bytes() -> None:
    message = encoding.binary_message("scan", b"\x01\x02\x03\x04", n=1)
    length = int.from_bytes(message[:4], "little")
    assert length % 4 == 0
    assert message[4:].startswith(b'{"kind":"scan","n":1}')
    assert encoding.split_message(message) == ({"kind": "scan", "n": 1}, b"\x01\x02\x03\x04")


@given(st.text(max_size=30), st.binary(max_size=50))
def test_any_text_and_payload_come_back(text: str, payload: bytes) -> None:
    message = encoding.binary_message("x", payload, text=text)
    assert encoding.split_message(message) == ({"kind": "x", "text": text}, payload)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_json_does_not_know_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="JSON"):
        encoding.text_message("pose", x=value)


def test_points_are_floats_in_a_row_and_those_that_are_none_are_left_out() -> None:
    points = np.array([[1.0, 2.0], [math.nan, 0.0], [0.0, math.inf], [-3.5, 4.0]])
    assert np.frombuffer(encoding.points_payload(points), "<f4").tolist() == [1.0, 2.0, -3.5, 4.0]


def test_a_line_with_an_end_that_is_none_is_left_out_whole() -> None:
    points = np.array([[0.0, 0.0], [math.nan, 0.0], [1.0, 2.0], [3.0, 4.0]])
    assert np.frombuffer(encoding.lines_payload(points), "<f4").tolist() == [1.0, 2.0, 3.0, 4.0]
    with pytest.raises(ValueError, match="two ends"):
        encoding.lines_payload(points[:3])


def test_a_picture_is_made_narrower_and_keeps_its_shape() -> None:
    pixels = np.full((100, 200, 3), (250, 10, 10), dtype=np.uint8)
    small = decoded(encoding.picture_jpeg(pixels, 50, 90))
    assert small.shape == (25, 50, 3)
    assert np.abs(small.astype(int) - (250, 10, 10)).max() < 10  # jpeg is not exact
    assert decoded(encoding.picture_jpeg(pixels[..., 0], 400, 90)).shape == (100, 200)


def test_a_cone_says_where_it_is_and_none_comes_of_no_number() -> None:
    cone = encoding.cone_values(SE2(1.0, 2.0, 0.5), 0.3, 4.0, is_echo=True)
    assert cone == {"x": 1.0, "y": 2.0, "yaw": 0.5, "opening": 0.3, "reach": 4.0, "echo": True}
    assert encoding.cone_values(SE2(1.0, 2.0, 0.5), 0.3, math.inf, is_echo=False) is None


def test_a_color_is_that_of_css_whatever_comes() -> None:
    assert encoding.color_text((1.0, 0.5, 0.0, 0.25)) == "rgba(255,128,0,0.25)"
    assert encoding.color_text((2.0, -1.0, math.nan, math.inf)) == "rgba(255,0,255,1.00)"


def test_the_outline_is_the_corners_given_or_a_circle() -> None:
    config = LiveViewConfig(outline_m=(1.0, 0.0, 0.0, 1.0, -1.0, 0.0))
    assert config.outline().tolist() == [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]
    circle = LiveViewConfig(radius_m=0.3).outline()
    assert np.allclose(np.hypot(*circle.T), 0.3)


@pytest.mark.parametrize("numbers", [(1.0,), (1.0, 2.0), (1.0, 2.0, 3.0, 4.0), (1.0,) * 7])
def test_an_outline_that_is_none_is_refused(numbers: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="three corners or more"):
        LiveViewConfig(outline_m=numbers)
