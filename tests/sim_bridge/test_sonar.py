"""Sonars by hand: first echo, mirrors, corners, cross-talk, limits, firing order."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim_bridge.ranging import fired_sonars
from sim_bridge.rays import Hits
from sim_bridge.sonar import cone_rays, first_echoes, readings
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.surfaces import NAMES

TOL_M = 2e-3
EXACT = SonarConfig(
    count=1, noise_sd_m=0.0, noise_sd_share=0.0, quantum_m=0.0, miss_share=0.0, critical_sd_rad=0.0
)
STEP_NS = 10_000_000


def _pose(x: float, y: float, yaw_deg: float) -> np.ndarray:
    c, s = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def _planes(*planes: tuple[tuple[float, float], float], surface: str = "smooth"):
    """Return a cast against upright walls n . p = d that are seen from the side n . p < d."""

    def cast(starts: np.ndarray, ends: np.ndarray) -> Hits:
        shares, normals = np.full(len(starts), np.inf), np.zeros((len(starts), 3))
        for flat, d in planes:
            n = np.array([*flat, 0.0])
            speed = (ends - starts) @ n
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (d - starts @ n) / speed
            is_hit = (speed > 0.0) & (t > 0.0) & (t <= 1.0) & (t < shares)
            shares[is_hit], normals[is_hit] = t[is_hit], -n
        return Hits(shares, normals, np.full(len(shares), NAMES.index(surface)))

    return cast


def _hear(config: SonarConfig, poses: list[np.ndarray], cast) -> np.ndarray:
    critical = np.full(len(poses), config.critical_rad)
    return first_echoes(config, np.array(poses), critical, cast, lambda *_: np.zeros((0, 3)))


WALL = _planes(((1.0, 0.0), 2.0))


def test_a_wall_ahead_answers_from_its_distance() -> None:
    assert _hear(EXACT, [_pose(0, 0, 0)], WALL) == pytest.approx([2.0], abs=TOL_M)


def test_a_wall_in_the_cone_answers_from_its_nearest_point_not_from_the_axis() -> None:
    assert _hear(EXACT, [_pose(0, 0, 8)], WALL) == pytest.approx([2.0], abs=TOL_M)


def test_beyond_cone_and_critical_angle_a_wall_gives_no_echo() -> None:
    # Half the cone is 10 degrees, the critical angle 15.
    assert np.isfinite(_hear(EXACT, [_pose(0, 0, 24)], WALL)).all()
    assert np.isinf(_hear(EXACT, [_pose(0, 0, 27)], WALL)).all()


def test_cloth_answers_at_a_slant_where_plaster_does_not() -> None:
    sofa, books = (_planes(((1.0, 0.0), 2.0), surface=name) for name in ("cloth", "rough"))
    # Critical: 15 degrees on plaster, 45 on books, 75 on cloth; half the cone is 10.
    assert np.isfinite(_hear(EXACT, [_pose(0, 0, 50)], books)).all()
    assert np.isinf(_hear(EXACT, [_pose(0, 0, 58)], books)).all()
    assert np.isfinite(_hear(EXACT, [_pose(0, 0, 58)], sofa)).all()


def test_a_mirror_sends_sound_on_to_a_longer_echo() -> None:
    narrow = replace(EXACT, opening_rad=math.radians(2.0))
    # 45 degrees on the mirror at x = 2, then straight onto the wall at y = 3.
    mirror = _planes(((math.sqrt(0.5), -math.sqrt(0.5)), math.sqrt(2.0)), ((0.0, 1.0), 3.0))
    assert _hear(narrow, [_pose(0, 0, 0)], mirror) == pytest.approx([2.0 + 3.0], abs=0.02)


def test_a_corner_sends_sound_home_from_the_distance_of_its_edge() -> None:
    corner = _planes(((1.0, 0.0), 2.0), ((0.0, 1.0), 2.0))
    assert _hear(EXACT, [_pose(0, 0, 45)], corner) == pytest.approx([math.sqrt(8.0)], abs=0.01)


def test_sonars_fired_together_hear_each_other_and_alone_they_do_not() -> None:
    # Both look at the wall at 30 degrees, towards each other's mirror image.
    left, right = _pose(0, 1.15, -30), _pose(0, -1.15, 30)
    both, alone = _hear(EXACT, [left, right], WALL), _hear(EXACT, [left], WALL)
    assert np.isinf(alone).all()
    assert both == pytest.approx([math.hypot(2.0, 1.15)] * 2, abs=0.02)


def test_limits_are_reported_as_rep_117_says() -> None:
    config = replace(EXACT, count=4)
    seen = readings(config, np.array([0.1, 1.0, 5.2]), (0, 1, 3), np.random.default_rng(0))
    assert [r.range for r in seen[:2]] == [-math.inf, 1.0]
    assert math.isnan(seen[2].range) and seen[3].range == math.inf


def test_ranges_come_in_steps_with_the_noise_promised() -> None:
    config = SonarConfig(
        count=64, period_s=0.64, noise_sd_m=0.03, noise_sd_share=0.02, miss_share=0.0
    )
    rng = np.random.default_rng(0)
    fired = tuple(range(64))
    seen = [r.range for _ in range(60) for r in readings(config, np.full(64, 2.0), fired, rng)]
    assert np.allclose(seen, np.round(seen, 2), atol=1e-9)
    assert np.std(seen) == pytest.approx(math.hypot(0.03, 0.04), rel=0.05)


def test_the_share_of_misses_is_the_one_promised() -> None:
    config = SonarConfig(count=64, period_s=0.64, miss_share=0.1)
    rng, fired = np.random.default_rng(0), tuple(range(64))
    seen = [r.range for _ in range(60) for r in readings(config, np.full(64, 2.0), fired, rng)]
    assert np.isinf(seen).mean() == pytest.approx(0.1, abs=0.015)


def test_rays_fill_the_cone_and_one_is_its_axis() -> None:
    rays = cone_rays(EXACT)
    assert np.linalg.norm(rays, axis=1) == pytest.approx(np.ones(len(rays)))
    assert (rays[:, 0] >= math.cos(EXACT.opening_rad / 2.0) - 1e-12).all()
    assert np.abs(rays - [1.0, 0.0, 0.0]).sum(axis=1).min() < 1e-12
    half = EXACT.opening_rad / 2.0
    for up in np.linspace(-1.0, 1.0, 21):
        for side in np.sqrt(1.0 - up**2) * np.linspace(-1.0, 1.0, 21):
            point = [1.0, np.tan(half * side), np.tan(half * up)] / np.linalg.norm(
                [1.0, np.tan(half * side), np.tan(half * up)]
            )
            # Rows are a third of half the cone apart: nothing is far from a ray.
            assert (rays @ point).max() > math.cos(math.radians(2.5)), (up, side)


def test_groups_fire_in_order_and_each_once_a_period() -> None:
    config = SonarConfig(count=4, period_s=0.1, groups=((0, 2), (3, 1)))
    slots = [fired_sonars(config, k * STEP_NS, STEP_NS) for k in range(1, 21)]
    assert [slot for slot in slots if slot] == [(0, 2), (3, 1), (0, 2), (3, 1)]
    assert slots[4] == (0, 2) and slots[9] == (3, 1)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"count": 4, "groups": ((0, 1), (1, 2))}, "once"),
        ({"range_min_m": 6.0}, "range_max_m"),
        ({"rays_across": 4}, "odd"),
    ],
)
def test_settings_that_cannot_be_are_refused(values: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        SonarConfig(**values)
