from dataclasses import replace

import numpy as np
import pytest

from multi_localizer.stereo_cameras import CameraModel, rectified_pair


def camera(baseline=0.0, focal=200.0, row=119.5, column=159.5, size=(320, 240), **changes):
    P = np.array(
        [[focal, 0, column, -focal * baseline], [0, focal, row, 0], [0, 0, 1, 0]], dtype=float
    )
    model = CameraModel(size, np.zeros(5), P[:, :3].copy(), np.eye(3), P)
    return replace(model, **changes)


def test_focal_length_and_baseline_are_read():
    pair = rectified_pair(camera(), camera(0.1, column=157.5))
    assert (pair.size, pair.focal_px) == ((320, 240), 200.0)
    assert pair.baseline_m == pytest.approx(0.1)
    assert pair.center_shift_px == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("left", "right", "why"),
    [
        (camera(), camera(0.1, size=(640, 480)), "sizes differ"),
        (camera(focal=0.0), camera(0.1), "left camera is not calibrated"),
        (camera(), camera(0.1, focal=201.0), "focal lengths differ"),
        (camera(), camera(0.1, row=121.0), "rows differ"),
        (camera(), camera(0.0), "no baseline"),
        (camera(), camera(-0.1), "exchanged"),
        (camera(), camera(0.1, distortion=np.array([-0.2, 0.0])), "right P is K"),
        (camera(), camera(0.1, distortion=np.array([np.nan])), "not finite"),
    ],
)
def test_what_is_no_rectified_pair_is_refused_with_the_reason(left, right, why):
    with pytest.raises(ValueError, match=why):
        rectified_pair(left, right)


def test_a_lens_that_distorts_is_taken_where_rectification_changed_the_image():
    bent = np.array([-0.2, 0.05, 0.0, 0.0, 0.0])
    left, right = camera(distortion=bent), camera(0.1, distortion=bent)
    turned = [replace(c, intrinsics=np.diag([190.0, 190.0, 1.0])) for c in (left, right)]
    assert rectified_pair(*turned).baseline_m == pytest.approx(0.1)


def squeezed(model, fy):
    P = model.projection.copy()
    P[1, 1] = fy
    return replace(model, projection=P, intrinsics=P[:, :3].copy())


def test_focal_lengths_along_rows_and_columns_are_not_mixed_up():
    left, right = squeezed(camera(focal=276.0), 280.0), squeezed(camera(0.1, focal=300.0), 280.0)
    with pytest.raises(ValueError, match="not rectified: the left P has focal lengths 276 and 280"):
        rectified_pair(left, right)
    with pytest.raises(ValueError, match="right P has focal lengths 500 and 250 px"):
        rectified_pair(camera(focal=500.0), squeezed(camera(0.1, focal=500.0), 250.0))
    nearly = [squeezed(c, 500.3) for c in (camera(focal=500.0), camera(0.1, focal=500.0))]
    pair = rectified_pair(*nearly)
    assert pair.focal_px == 500.0 and pair.baseline_m == pytest.approx(0.1)
    far = [squeezed(camera(focal=500.0), 500.4), squeezed(camera(0.1, focal=500.4), 500.0)]
    with pytest.raises(ValueError, match="focal lengths differ, 500 and 500.4"):
        rectified_pair(*far)
