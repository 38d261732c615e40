import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multi_localizer.stereo_fill import fill_from_farther

NAN = np.nan


def test_holes_take_the_smaller_disparity_beside_them():
    row = np.array([[NAN, 8.0, NAN, NAN, 3.0, NAN, 5.0, NAN]], dtype=np.float32)
    assert fill_from_farther(row).tolist() == [[8.0, 8.0, 3.0, 3.0, 3.0, 3.0, 5.0, 5.0]]


def test_a_row_of_holes_takes_the_nearest_row():
    image = np.full((4, 2), NAN, dtype=np.float32)
    image[1], image[3, 1] = 7.0, 2.0
    assert fill_from_farther(image).tolist() == [[7, 7], [7, 7], [7, 7], [2, 2]]


def test_nothing_known_stays_unknown():
    assert np.isnan(fill_from_farther(np.full((3, 4), NAN, np.float32))).all()


values = st.one_of(st.just(NAN), st.floats(0, 63, width=32))


@given(arrays(np.float32, (3, 7), elements=values))
def test_what_is_known_stays_and_nothing_new_is_made_up(image):
    before = image.copy()
    filled = fill_from_farther(image)
    known = ~np.isnan(before)
    assert np.array_equal(image, before, equal_nan=True)
    assert np.array_equal(filled[known], before[known])
    if known.any():
        assert not np.isnan(filled).any()
        assert set(filled.ravel()) <= set(before[known])
    assert np.array_equal(fill_from_farther(filled), filled, equal_nan=True)
