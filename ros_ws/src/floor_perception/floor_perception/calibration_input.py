"""Reads what a camera is calibrated from: tables of measurements, and pictures."""

from __future__ import annotations

import csv
import gzip
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

_METRES = {"_m": 1.0, "_cm": 0.01, "_mm": 0.001}
_PICTURES = (".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp", ".tif", ".tiff", ".gz")
PAIRS, POINTS, CHECKERBOARD = "pairs", "points", "checkerboard"


@dataclass(frozen=True)
class Table:
    """A table of measurements.

    Attributes:
        job: `pairs` or `points`.
        pixels: Radii, shape (N,), or (u, v), shape (N, 2).
        metres: Distances, shape (N,), or (x, y), shape (N, 2).
        lines: Line of the file of each row.
    """

    job: str
    pixels: np.ndarray
    metres: np.ndarray
    lines: tuple[int, ...]


def job_of(inputs: list[Path]) -> str | None:
    """Return `checkerboard` for pictures or a folder of them, None for a table.

    Raises:
        ValueError: Neither, or both.
    """
    are_pictures = {path.is_dir() or path.suffix.lower() in _PICTURES for path in inputs}
    if are_pictures == {True}:
        return CHECKERBOARD
    if len(inputs) != 1:
        raise ValueError("give one table, or pictures only")
    return None


def read_table(path: Path) -> Table:
    """Read measurements with a header: `radius_px,distance_m` or `u_px,v_px,x_m,y_m`.

    Lengths may be in m, cm or mm, as the header says. Separators: comma, semicolon, tab or blanks;
    `#` begins a comment.

    Raises:
        ValueError: Another header, or a row that does not hold these numbers; with its line.
        OSError: The file cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not a text file") from error
    rows = [(k + 1, _cells(line)) for k, line in enumerate(text.splitlines())]
    rows = [(line, cells) for line, cells in rows if cells]
    if not rows:
        raise ValueError(f"{path}: is empty")
    job, columns, scales = _columns(rows[0][1], path)
    values = np.array([_numbers(cells, len(rows[0][1]), path, line) for line, cells in rows[1:]])
    if not len(values):
        raise ValueError(f"{path}: has no measurement below its header")
    picked = values[:, columns] * scales
    lines = tuple(line for line, _ in rows[1:])
    half = len(columns) // 2
    pixels, metres = picked[:, :half], picked[:, half:]
    if job == PAIRS:
        return Table(job, pixels[:, 0], metres[:, 0], lines)
    return Table(job, pixels, metres, lines)


def picture_files(inputs: list[Path]) -> list[Path]:
    """Return the pictures, those of folders in the order of their names."""
    files: list[Path] = []
    for path in inputs:
        inside = sorted(path.iterdir()) if path.is_dir() else [path]
        files += [f for f in inside if f.suffix.lower() in _PICTURES]
    if not files:
        raise ValueError("no pictures found")
    return files


def read_gray(path: Path) -> np.ndarray:
    """Return a picture in gray, shape (H, W), uint8; also from a `.gz`.

    Raises:
        ValueError: It is no picture.
        OSError: It cannot be read.
    """
    data = path.read_bytes()
    if path.suffix.lower() == ".gz":
        try:
            data = gzip.decompress(data)
        except (EOFError, gzip.BadGzipFile) as error:
            raise ValueError(f"{path}: cannot be unpacked: {error}") from error
    gray = None
    if data:
        gray = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)
    if gray is None:
        raise ValueError(f"{path}: not a picture that OpenCV reads")
    return np.asarray(gray)


def _cells(line: str) -> list[str]:
    bare = line.split("#", 1)[0].strip()
    for separator in (",", ";", "\t"):
        if separator in bare:
            return [c.strip() for c in next(csv.reader([bare], delimiter=separator))]
    return bare.split()


def _columns(header: list[str], path: Path) -> tuple[str, list[int], np.ndarray]:
    names = [name.lower() for name in header]
    for job, wanted in ((POINTS, ("u_px", "v_px", "x", "y")), (PAIRS, ("radius_px", "distance"))):
        found = [_column(names, name) for name in wanted]
        if all(f is not None for f in found):
            picked = [f for f in found if f is not None]
            return job, [k for k, _ in picked], np.array([scale for _, scale in picked])
    raise ValueError(
        f"{path}: the first line must name the columns: radius_px,distance_m or u_px,v_px,x_m,y_m "
        f"(lengths in _m, _cm or _mm), got: {' '.join(header)}"
    )


def _column(names: list[str], wanted: str) -> tuple[int, float] | None:
    if wanted.endswith("_px"):
        return (names.index(wanted), 1.0) if wanted in names else None
    for ending, scale in _METRES.items():
        if wanted + ending in names:
            return names.index(wanted + ending), scale
    return None


def _numbers(cells: list[str], count: int, path: Path, line: int) -> list[float]:
    if len(cells) != count:
        raise ValueError(f"{path}:{line}: expected {count} values, got {len(cells)}")
    try:
        return [float(cell) for cell in cells]
    except ValueError as error:
        raise ValueError(f"{path}:{line}: {error}") from error
