import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.drift import KEPT_SHARE, Drift, carried
from grid_mapper.key_frames import chain_cov
from grid_mapper.match_verdict import ScanResult
from grid_mapper.motion import odometry_motion, rotated

CONFIG = GridMapperConfig()
DRIFT = CONFIG.loop.drift_m, CONFIG.loop.drift_rad
MATCH = np.diag([1e4, 1e4, 1e6])  # 1 cm, 1 mrad
SLACK = 1e-12
poses = st.builds(SE2, st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3))


def scan_at(pose, information=MATCH, cov=None, is_trusted=True):
    cov = np.diag([1e-4, 1e-4, 1e-6]) if cov is None else cov
    return ScanResult(pose, cov, is_trusted, "", 1.0, "", information)


def covs_along(poses, every=2, informations=None):
    drift, found = Drift(), []
    for k, pose in enumerate(poses):
        information = MATCH if informations is None else informations[k]
        result = scan_at(pose, None if k == 0 else information)
        found.append(drift.of(result, k % every == 0, CONFIG).cov)
    return found


def test_a_turn_that_is_not_known_sweeps_the_end_of_a_straight_way_sideways():
    cov = np.diag([0.01, 0.04, 0.09])
    # y at the end of 2 m: 0.04 + 2^2 * 0.09; y and yaw go together by 2 * 0.09.
    expected = [[0.01, 0.0, 0.0], [0.0, 0.4, 0.18], [0.0, 0.18, 0.09]]
    assert np.allclose(carried(cov, SE2(2.0, 0.0, 0.0)), expected)


def test_a_quarter_turn_on_the_spot_swaps_forward_and_sideways():
    turned = carried(np.diag([0.01, 0.04, 0.09]), SE2(0.0, 0.0, np.pi / 2.0))
    assert np.allclose(turned, np.diag([0.04, 0.01, 0.09]))


@given(poses, poses)
def test_carrying_is_the_derivative_of_the_end_by_the_start(start, moved):
    step, columns = 1e-6, []
    for k in range(3):
        error = SE2(*(step * np.eye(3)[k]))
        off = (start @ moved).between(start @ error @ moved)
        columns.append(off.as_array() / step)
    A, cov = np.column_stack(columns), np.diag([0.01, 0.04, 0.09])
    assert np.allclose(carried(cov, moved), A @ cov @ A.T, atol=1e-4)


def test_what_stays_of_a_motion_adds_up_and_the_newest_counts_whole():
    way = [SE2(0.3 * k, 0.0, 0.0) for k in range(3)]
    start, step = np.diag([1e-4, 1e-4, 1e-6]), SE2(0.3, 0.0, 0.0)
    own = chain_cov(way[0], way[1], MATCH, CONFIG.motion, DRIFT)
    found = covs_along(way, every=1)
    assert np.allclose(found[0], start)
    assert np.allclose(found[1], carried(start, step) + own)
    kept = carried(start, step) + KEPT_SHARE * own
    assert np.allclose(found[2], carried(kept, step) + own)


def test_it_grows_along_a_straight_drive_in_every_direction():
    covs = covs_along([SE2(0.3 * k, 0.0, 0.0) for k in range(200)], every=1)
    variances = np.array([np.diag(cov) for cov in covs])
    assert (np.diff(variances, axis=0) > 0.0).all()
    # Sideways a turn that is not known adds up faster than the way does.
    assert variances[199, 1] > 4.0 * variances[99, 1]


@given(st.lists(poses, min_size=2, max_size=8))
def test_it_is_never_surer_than_match_and_odometry_since_the_last_node(poses):
    covs = covs_along(poses)
    for k in range(1, len(poses)):
        node = (k - 1) // 2 * 2
        odometry = odometry_motion(poses[node].between(poses[k]), CONFIG.motion)
        odometry = rotated(odometry, poses[node].yaw)
        own = np.linalg.inv(np.linalg.inv(odometry) + MATCH)
        assert np.linalg.eigvalsh(covs[k] - own).min() >= -SLACK


def test_a_scan_that_is_not_trusted_is_less_sure_than_its_node():
    drift, cov = Drift(), np.diag([0.1, 0.1, 0.1])
    node = drift.of(scan_at(SE2.identity(), None), True, CONFIG)
    lost = drift.of(scan_at(SE2.identity(), None, cov, is_trusted=False), False, CONFIG)
    assert np.allclose(lost.cov, node.cov + cov)


def test_after_a_restart_the_next_scan_is_as_sure_as_its_match():
    drift = Drift()
    for k in range(9):
        drift.of(scan_at(SE2(0.3 * k, 0.0, 0.0)), True, CONFIG)
    drift.restart()
    found = scan_at(SE2.identity())
    assert np.allclose(drift.of(found, True, CONFIG).cov, found.cov)


@given(poses, poses)
def test_moving_the_frame_turns_the_covariance_with_it(frame, start):
    way = [start @ SE2(0.3 * k, 0.1 * k, 0.2 * k) for k in range(4)]
    moved = [frame @ pose for pose in way]
    informations = [rotated(MATCH, frame.yaw)] * 4
    start_cov = np.diag([1e-4, 1e-4, 1e-6])
    assert np.allclose(rotated(start_cov, frame.yaw), start_cov)
    for a, b in zip(covs_along(way), covs_along(moved, informations=informations), strict=True):
        assert np.allclose(rotated(a, frame.yaw), b)
