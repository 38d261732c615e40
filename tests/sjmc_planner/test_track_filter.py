"""Two filters a track: against the textbook's equations, and as a law."""

from __future__ import annotations

import numpy as np
import pytest

from sjmc_planner.track_filter import STANDS, WALKS, correct, distance2, mix, predict, start

F = np.eye(4) + 0.1 * np.eye(4, k=2)


def begun() -> tuple[np.ndarray, np.ndarray]:
    mean, cov = np.empty((2, 4)), np.empty((2, 4, 4))
    start(mean, cov, 1.0, 2.0, 0.1)
    return mean, cov


def test_a_track_begins_where_it_was_seen_at_rest() -> None:
    mean, cov = begun()
    assert np.array_equal(mean, [[1.0, 2.0, 0.0, 0.0]] * 2)
    assert np.allclose(np.diag(cov[WALKS]), (0.01, 0.01, 0.64, 0.64))


def test_mixing_two_gives_mean_and_spread_by_hand() -> None:
    mean, cov = np.zeros((2, 4)), np.stack((np.eye(4), np.eye(4)))
    mean[1, 2] = 2.0
    mixed, spread = mix(mean, cov, 0.25)
    assert np.allclose(mixed, (0.0, 0.0, 0.5, 0.0))
    # 1 + 0.75 * 0.5^2 + 0.25 * 1.5^2
    assert np.allclose(np.diag(spread), (1.0, 1.0, 1.75, 1.0))


def test_a_correction_is_the_kalman_filters() -> None:
    mean, cov = begun()
    rng = np.random.default_rng(0)
    A = rng.standard_normal((4, 4))
    cov[WALKS] = A @ A.T
    P, m, z, R = cov[WALKS].copy(), mean[WALKS].copy(), np.array([1.3, 1.6]), 0.04
    H = np.eye(2, 4)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R * np.eye(2))
    correct(mean, cov, 0.5, z[0], z[1], R, 0.0, True)
    assert np.allclose(mean[WALKS], m + K @ (z - m[:2]))
    assert np.allclose(cov[WALKS], (np.eye(4) - K @ H) @ P)


def test_the_distance_is_mahalanobis() -> None:
    mean, cov = begun()
    d2, log_det = distance2(mean[WALKS], cov[WALKS], 1.3, 2.4, 0.03)
    assert d2 == pytest.approx(0.25 / 0.04)
    assert log_det == pytest.approx(2.0 * np.log(0.04))


def test_what_surely_walks_is_predicted_with_constant_velocity() -> None:
    mean, cov = begun()
    mean[WALKS, 2:] = 1.0, -0.5
    P = cov[WALKS].copy()
    predict(mean, cov, 1.0, 0.0, 0.1)
    assert np.allclose(mean[WALKS], (1.1, 1.95, 1.0, -0.5), atol=1e-9)
    assert np.allclose(cov[WALKS], F @ P @ F.T)
    assert np.array_equal(mean[STANDS, 2:], (0.0, 0.0))


def test_time_alone_keeps_probabilities_between_their_bounds() -> None:
    mean, cov = begun()
    p = 0.999
    for _ in range(1000):
        p = predict(mean, cov, p, 1.0, 0.1)
        mean[:], cov[:] = begun()
    assert p == pytest.approx(5.0 / 25.0, abs=0.02)  # 5 s of walking to 20 s of standing


def test_a_place_alone_does_not_make_it_walk() -> None:
    mean, cov = begun()
    p = 0.1
    for k in range(20):
        p = predict(mean, cov, p, 1.0, 0.1)
        p = correct(mean, cov, p, 1.0 + 0.1 * k, 2.0, 0.0025, 0.0, False)
    assert p < 0.5


def test_what_goes_on_into_free_space_walks_and_its_speed_is_found() -> None:
    mean, cov = begun()
    p = 0.1
    for k in range(20):
        p = predict(mean, cov, p, 1.0, 0.1)
        p = correct(mean, cov, p, 1.1 + 0.1 * k, 2.0, 0.0025, 1.2, True)
    assert p > 0.99
    assert np.allclose(mix(mean, cov, p)[0][2:], (1.0, 0.0), atol=0.05)


def test_covariances_stay_symmetric_and_positive() -> None:
    rng = np.random.default_rng(1)
    mean, cov = begun()
    p = 0.1
    for _ in range(300):
        p = predict(mean, cov, p, 1.5, float(rng.choice([0.05, 0.1])))
        if rng.random() < 0.7:
            x, y = mean[WALKS, :2] + 0.1 * rng.standard_normal(2)
            p = correct(mean, cov, p, x, y, 0.0025, float(rng.uniform(-1, 1)), rng.random() < 0.5)
        for P in cov:
            assert np.allclose(P, P.T, atol=1e-9)
            assert np.linalg.eigvalsh(P).min() > 0.0
