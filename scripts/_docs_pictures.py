"""Pictures for docs/: cropped, at most 1000 pixels wide and high, at most 150 kB."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

from floornav_common.reporting import UserError, say, write_atomic

MAX_SIDE_PX = 1000
MAX_BYTES = 150_000
MAX_FILM_BYTES = 3_000_000
COLOR_BITS = (5, 4, 3)
JPEG_QUALITIES = (85, 75, 65)
MARGIN_PX = 8
DEMO = Path(__file__).resolve().parent / "demo.py"


def write_small(source: Path, target: Path, max_side_px: int = MAX_SIDE_PX) -> None:
    """Write a picture smaller: white edges cut off, scaled down; fewer colors, or as a JPEG.

    Raises:
        UserError: If it cannot be read.
        ValueError: If it stays too large.
    """
    image = cv2.imread(str(source), cv2.IMREAD_COLOR)
    if image is None:
        raise UserError(f"{source} cannot be read as a picture")
    make = small_jpeg if target.suffix == ".jpg" else small_png
    data = make(image, max_side_px)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(target, data)
    say(f"written: {target} ({len(data) / 1000:.0f} kB)")


def small_png(image: np.ndarray, max_side_px: int = MAX_SIDE_PX) -> bytes:
    """Return a picture, shape (H, W, 3), uint8, as a PNG within the limits.

    Raises:
        ValueError: If it stays larger than 150 kB.
    """
    image = cut_white(image)
    scale = min(1.0, max_side_px / max(image.shape[:2]))
    while scale > 0.3:
        scaled = _scaled(image, scale)
        for bits in COLOR_BITS:
            data: bytes = cv2.imencode(
                ".png", with_bits(scaled, bits), [cv2.IMWRITE_PNG_COMPRESSION, 9]
            )[1].tobytes()
            if len(data) <= MAX_BYTES:
                return data
        scale *= 0.85
    raise ValueError(f"a picture of {image.shape[1]} x {image.shape[0]} does not fit 150 kB")


def small_jpeg(image: np.ndarray, max_side_px: int = MAX_SIDE_PX) -> bytes:
    """Return a picture with much texture, shape (H, W, 3), uint8, as a JPEG within the limits.

    Raises:
        ValueError: If it stays larger than 150 kB.
    """
    image = cut_white(image)
    scaled = _scaled(image, min(1.0, max_side_px / max(image.shape[:2])))
    for quality in JPEG_QUALITIES:
        data: bytes = cv2.imencode(".jpg", scaled, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        if len(data) <= MAX_BYTES:
            return data
    raise ValueError(f"a picture of {image.shape[1]} x {image.shape[0]} does not fit 150 kB")


def _scaled(image: np.ndarray, scale: float) -> np.ndarray:
    size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
    return image if scale == 1.0 else cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def cut_white(image: np.ndarray) -> np.ndarray:
    """Return the picture without its white edges but for a small margin."""
    rows, columns = np.nonzero((image < 250).any(axis=2))
    if len(rows) == 0:
        return image
    top, left = max(rows.min() - MARGIN_PX, 0), max(columns.min() - MARGIN_PX, 0)
    return image[top : rows.max() + MARGIN_PX, left : columns.max() + MARGIN_PX]


def with_bits(image: np.ndarray, bits: int) -> np.ndarray:
    """Return the picture with so many bits a channel; black stays black and white white."""
    top = (1 << bits) - 1
    levels = np.rint(image * (top / 255.0))
    return np.rint(levels * (255.0 / top)).astype(np.uint8)


def make_demo(pictures: Path) -> None:
    """Run the demo without a window; keep its maps as a picture, and its film.

    Raises:
        UserError: If the demo fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        for world, picture in (("flat_day", "flat-day.png"), ("furnished_floor", "demo.png")):
            out = Path(folder) / world
            words = [sys.executable, str(DEMO), world, "--headless", "--film", "--out", str(out)]
            if subprocess.run(words).returncode != 0:
                raise UserError(f"the demo of {world} failed, so its picture stays as it was")
            write_small(out / "map.png", pictures / picture)
        film = (Path(folder) / "flat_day" / "film.gif").read_bytes()
        if len(film) > MAX_FILM_BYTES:
            raise UserError(f"the film holds {len(film) / 1e6:.1f} MB; at most 3 MB are wanted")
        write_atomic(pictures / "flat-day.gif", film)
