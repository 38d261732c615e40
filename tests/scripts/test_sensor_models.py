"""The experiment sensor-models: small runs keep what the settings promise, wrong sensors do not."""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from experiments import sensor_models_odometry
from experiments.sensor_models_glass import glass_by_angle
from experiments.sensor_models_laser import laser_noise
from experiments.sensor_models_odometry import odometry_drift
from experiments.sensor_models_sonar import sonar_by_angle
from experiments.sensor_models_textbook import (
    cross_talk_range,
    delay_of_a_pane,
    dirt_share,
    light_through_a_pane,
    lost_share,
    mirror_share,
    reflectance_of_a_face,
)
from sim_bridge import panes, ranging, wheels


@pytest.mark.parametrize(
    ("measure", "scans"),
    [(laser_noise, 60), (glass_by_angle, 160), (sonar_by_angle, 0), (odometry_drift, 0)],
)
def test_what_is_measured_is_what_was_promised(
    measure, scans: int, tmp_path: Path, monkeypatch
) -> None:
    ways = sensor_models_odometry.WAYS
    monkeypatch.setattr(sensor_models_odometry, "WAYS", (ways[0], ways[-1]))
    args = argparse.Namespace(scans=scans, runs=16, seed=1, out_dir=tmp_path)
    values, section = measure(args)
    assert values["kept"], values
    assert section.blocks


def test_a_covariance_that_promises_too_much_is_not_kept(monkeypatch) -> None:
    true_cov = wheels.pose_cov
    monkeypatch.setattr(wheels, "pose_cov", lambda *args: true_cov(*args) / 9.0)
    monkeypatch.setattr(sensor_models_odometry, "WAYS", sensor_models_odometry.WAYS[:1])
    rows = sensor_models_odometry.consistency(argparse.Namespace(runs=8, seed=1))
    assert [row["kept"] for row in rows] == [False]


ANGLES = np.radians([0.0, 30.0, 45.0, 60.0, 75.0])


def test_fresnel_reflectances_of_glass_by_table() -> None:
    # n = 1.52, by hand from cos i and cos t = 1, .944349, .885205, .821816, .772119 in the other
    # form, ((cos i - n cos t) / (cos i + n cos t))^2 and ((cos t - n cos i) / (cos t + n cos i))^2.
    across, along = reflectance_of_a_face(ANGLES, 1.52)
    assert across == pytest.approx([0.04258, 0.06121, 0.09673, 0.18344, 0.40785], abs=1e-5)
    assert along == pytest.approx([0.04258, 0.02708, 0.00936, 0.00153, 0.10558], abs=1e-5)


def test_other_curves_by_hand() -> None:
    assert 1e3 * delay_of_a_pane(ANGLES, 1.52, 0.008) == pytest.approx(
        [4.160, 4.555, 5.107, 5.993, 7.318], abs=1e-3
    )
    assert light_through_a_pane(np.zeros(1), 1.52, 0.8) == pytest.approx([0.8])
    # (1 - R) / (1 + R) of the table at 60 degrees, and 0.8 / 0.91832 on 1 / 0.82182 of the way.
    clear = ((1 - 0.18344) / (1 + 0.18344) + (1 - 0.00153) / (1 + 0.00153)) / 2.0
    assert light_through_a_pane(ANGLES[3:4], 1.52, 0.8) == pytest.approx(
        [clear * (0.8 / 0.91832) ** (1.0 / 0.82182)], abs=1e-5
    )
    assert mirror_share(np.array([0.0, 0.1]), 0.9, 0.1) == pytest.approx([0.9, 0.45])
    assert dirt_share(ANGLES[3:4], 0.1) == pytest.approx([0.19])
    even = lost_share(np.array([5.0]), np.array([0.0]), 10.0, np.array([0.5]), 0.1)
    assert even == pytest.approx([0.5])


def test_cross_talk_by_hand() -> None:
    # Half way between the two lies the spot: both are hypot(2, 0.5) from it.
    told = cross_talk_range(
        np.array([0.0, 0.5]), -0.2, np.array([0.0, -0.5]), 0.2, 2.0, 0.2, 0.3, 0.3
    )
    assert told == pytest.approx(np.hypot(2.0, 0.5), abs=1e-6)
    deaf = cross_talk_range(
        np.array([0.0, 0.5]), 0.1, np.array([0.0, -0.5]), -0.2, 2.0, 0.05, 0.3, 0.05
    )
    assert np.isinf(deaf)


def _measure(measure, tmp_path: Path) -> dict:
    return measure(argparse.Namespace(scans=160, runs=16, seed=1, out_dir=tmp_path))[0]


def test_a_wrong_delay_of_light_in_glass_is_found_out(monkeypatch, tmp_path: Path) -> None:
    right = panes.optical_delay
    monkeypatch.setattr(panes, "optical_delay", lambda g, c: 1.1 * right(g, c))
    assert not _measure(glass_by_angle, tmp_path)["kept"]


def test_panes_crossed_without_regard_to_the_robots_yaw_are_found_out(
    monkeypatch, tmp_path: Path
) -> None:
    right = panes.crossings

    def unturned(glass, origin, directions, reach):
        angles = np.arctan2(directions[:, 1], directions[:, 0])
        angles = angles - angles.mean()
        level = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(len(angles))))
        return right(glass, origin, level, reach)

    monkeypatch.setattr(ranging, "crossings", unturned)
    assert not _measure(glass_by_angle, tmp_path)["kept"]


@pytest.mark.parametrize("mutant", ["listening", "critical"])
def test_wrong_sonars_are_found_out(monkeypatch, tmp_path: Path, mutant: str) -> None:
    right = ranging.first_echoes

    def wrong(config, poses, critical, cast, nearest):
        if mutant == "listening":
            config = replace(config, listening_rad=3.0)
        else:
            critical = np.full(len(poses), config.critical_rad)
        return right(config, poses, critical, cast, nearest)

    monkeypatch.setattr(ranging, "first_echoes", wrong)
    assert not _measure(sonar_by_angle, tmp_path)["kept"]
