"""A small recording in the files of UTIAS MRCLAM: three robots drive circles among landmarks."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np

LANDMARKS = {
    6: (4.0, 0.5), 7: (-0.5, 4.2), 8: (-3.8, -1.0), 9: (1.2, -4.0), 10: (3.0, 3.2), 11: (-2.6, 2.9),
}  # fmt: skip
BARCODES = {subject: 100 - subject for subject in (1, 2, 3, 4, 5, *LANDMARKS)}
STARTS = {1: (1.5, 0.0, 1.5), 2: (-1.2, 1.0, -2.4), 3: (0.3, -1.8, 0.4)}
SPEED, YAW_RATE, DELAY_S, DT_S = 0.15, 0.1, 0.28, 0.05
FIRST_S = 1_000_000_000.0


def write_recording(folder: Path, duration: float, seed: int = 0, half_view: float = 0.9) -> Path:
    """Write the files of robots 1 to 3 and return the folder; ranges are rubbish on purpose."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    lines = [f"{subject} {code}" for subject, code in BARCODES.items()]
    (folder / "Barcodes.dat").write_text("# Subject Barcode\n" + "\n".join(lines) + "\n")
    lines = [f"{k} {x} {y} 0.0001 0.0001" for k, (x, y) in LANDMARKS.items()]
    (folder / "Landmark_Groundtruth.dat").write_text("# x y\n" + "\n".join(lines) + "\n")
    times = np.arange(0.0, duration, DT_S)
    paths = {robot: _path(start, times) for robot, start in STARTS.items()}
    for robot, path in paths.items():
        stamps = FIRST_S + times
        _write(folder, f"Robot{robot}_Odometry", [
            f"{t - DELAY_S:.3f} {SPEED} {YAW_RATE}" for t in stamps
        ])  # fmt: skip
        _write(folder, f"Robot{robot}_Groundtruth", [
            f"{t:.3f} {x:.6f} {y:.6f} {yaw:.6f}"
            for t, (x, y, yaw) in zip(stamps, path, strict=True)
        ])  # fmt: skip
        looks = [
            f"{stamps[k]:.3f} {BARCODES[subject]} {rng.uniform(1, 9):.3f} {bearing:.4f}"
            for k in range(0, len(times), 5)
            for subject, bearing in _seen(robot, k, paths, half_view, rng)
        ]
        _write(folder, f"Robot{robot}_Measurement", [*looks, f"{stamps[-1]:.3f} 7777 1.0 0.0"])
    return folder


def _path(start: tuple[float, float, float], times: np.ndarray) -> np.ndarray:
    yaw = start[2] + YAW_RATE * times
    radius = SPEED / YAW_RATE
    x = start[0] + radius * (np.sin(yaw) - np.sin(start[2]))
    y = start[1] - radius * (np.cos(yaw) - np.cos(start[2]))
    return np.stack([x, y, yaw], axis=1)


def _seen(
    robot: int, k: int, paths: dict[int, np.ndarray], half_view: float, rng: np.random.Generator
) -> list[tuple[int, float]]:
    x, y, yaw = paths[robot][k]
    others = {other: path[k, :2] for other, path in paths.items() if other != robot}
    found = []
    for subject, (px, py) in {**LANDMARKS, **others}.items():
        bearing = (np.arctan2(py - y, px - x) - yaw + np.pi) % (2.0 * np.pi) - np.pi
        if abs(bearing) < half_view:
            found.append((subject, float(bearing + 0.005 * rng.normal())))
    return found


def _write(folder: Path, name: str, lines: list[str]) -> None:
    text = "# made by a test\n" + "\n".join(lines) + "\n"
    (folder / f"{name}.dat.gz").write_bytes(gzip.compress(text.encode(), mtime=0))
