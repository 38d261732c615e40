"""The boxes of pictures of a floor: lines of class, center and size in parts of the picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

CLASSES = (1, 2)  # obstacle, human


def all_boxes(path: Path, width: int, height: int, classes: tuple[int, ...] = ()) -> list[Any]:
    """Return boxes as rows and columns; of some classes, or of all."""
    if not path.exists():
        return []
    boxes = []
    for line in path.read_text(encoding="utf-8").splitlines():
        kind, x, y, w, h = (float(v) for v in line.split())
        if classes and int(kind) not in classes:
            continue
        ends = [
            (y - h / 2) * height,
            (y + h / 2) * height,
            (x - w / 2) * width,
            (x + w / 2) * width,
        ]
        a, b, c, d = (round(v) for v in np.clip(ends, 0, [height, height, width, width]))
        boxes.append((slice(a, b), slice(c, d)))
    return boxes


def standing_boxes(path: Path, width: int, height: int, horizon: float) -> list[Any]:
    """Return the boxes of obstacles and humans that stand on the floor."""
    boxes = all_boxes(path, width, height, CLASSES)
    return [box for box in boxes if box[0].stop > horizon * height]


def middle_of(box: tuple[slice, slice]) -> tuple[slice, slice]:
    """Return the middle of a box: 0.6 of its height, a third of its width."""
    rows, columns = box
    tall, wide = rows.stop - rows.start, columns.stop - columns.start
    return (
        slice(rows.start + round(0.2 * tall), rows.stop - round(0.2 * tall)),
        slice(columns.start + wide // 3, columns.stop - wide // 3),
    )
