"""Disparities as messages and back."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("stereo_msgs", reason="no ROS messages")

from std_msgs.msg import Header

from multi_localizer.ros_conversions import disparities_from_msg, disparities_to_msg
from multi_localizer.stereo_cameras import RectifiedPair

PAIR = RectifiedPair((3, 2), 100.0, 0.1, 0.0)


def test_there_and_back_again():
    disparities = np.array([[1.5, np.nan, 0.0], [63.0, 7.25, np.nan]], dtype=np.float32)
    msg = disparities_to_msg(disparities, PAIR, 64, Header())
    assert disparities_from_msg(msg) == pytest.approx(disparities, nan_ok=True)


def test_rows_may_be_padded_and_what_is_not_whole_is_refused():
    values = np.array([[1.0, 2.0, 9.0], [3.0, 4.0, 9.0]], dtype=np.float32)
    msg = disparities_to_msg(values, PAIR, 64, Header())
    msg.image.width = 2
    assert disparities_from_msg(msg).tolist() == [[1.0, 2.0], [3.0, 4.0]]
    msg.image.height = 3
    with pytest.raises(ValueError, match="24 bytes"):
        disparities_from_msg(msg)
    msg.image.encoding = "16UC1"
    with pytest.raises(ValueError, match="32FC1"):
        disparities_from_msg(msg)
