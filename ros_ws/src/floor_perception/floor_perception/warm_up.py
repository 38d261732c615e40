"""Compiles every kernel, so that the first image is no slower than the rest."""

from __future__ import annotations

import numpy as np

from floor_perception.color_model import FloorColor
from floor_perception.color_table import color_table
from floor_perception.config import ColorConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.free_space import floor_areas, ratios_and_ranges


def compile_kernels(detector: FloorDetector) -> None:
    """Look up and count an image of nothing; compiled code is kept on disk."""
    color = FloorColor(np.array([0.3, 0.4]), 1e-3 * np.eye(2), 90.0, 100.0, 110.0)
    table = color_table(color, ColorConfig())
    black = np.zeros((*detector.template.cells.shape, 3), dtype=np.uint8)
    for image in (black, _read_only(black)):
        areas = floor_areas(detector.masker.mask(image, table), detector.template)
        ratios, _ = ratios_and_ranges(areas, detector.template, 0.5)
        detector.glare.unseen(image, ratios, 0.5, 0.5)


def _read_only(image: np.ndarray) -> np.ndarray:
    """Return the image as messages hold it: numba compiles arrays that may be written apart."""
    view = image.view()
    view.flags.writeable = False
    return view
