"""The experiment sensor-models: small runs keep what the settings promise."""

import argparse
from pathlib import Path

import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from experiments.sensor_models_laser import glass_by_angle, laser_noise
from experiments.sensor_models_odometry import odometry_drift
from experiments.sensor_models_sonar import sonar_by_angle


@pytest.mark.parametrize(
    ("measure", "scans"),
    [(laser_noise, 60), (glass_by_angle, 60), (sonar_by_angle, 0), (odometry_drift, 0)],
)
def test_what_is_measured_is_what_was_promised(measure, scans: int, tmp_path: Path) -> None:
    args = argparse.Namespace(scans=scans, runs=16, seed=1, out_dir=tmp_path)
    values, section = measure(args)
    assert values["kept"], values
    assert section.blocks
