"""Floor mask and free space on real pictures, without calibration.

The floor's color is learned anew in each picture from a region that is mostly floor. After opening
and closing only what hangs together with that region is floor. Free space is looked for from the
region's lower edge upwards, column by column, with the same cells and threshold as on a robot.

`field_floor_share`: of the region, without boxes and without black (outside of the lens, the robot
itself), how much is labelled floor. `box_floor_share`: of the middles of obstacle and human boxes
that stand on the floor (a third as wide, 0.6 as high: corners of a box show what is behind), how
much is labelled floor. Boxes are as in the recordings: lines of class, center and size in parts of
the picture; a box stands on the floor if its lower edge lies below the horizon given.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from experiments.floor_image_boxes import all_boxes, middle_of, standing_boxes
from floor_perception.color_model import FloorColor, learn
from floor_perception.color_table import classify, color_table
from floor_perception.config import ColorConfig, TemplateConfig
from floor_perception.free_space import floor_areas, ratios_and_ranges
from floor_perception.polar_template import PolarTemplate, row_spans
from floornav_common.arguments import share
from floornav_common.reporting import Figures, Picture, Section, Table, UserError

MAX_SIDE_PX = 800
BRIDGE_PX, SPECK_PX = 7, 5
NUM_COLUMNS, CELL_ROWS = 38, 6
BLACK = 60  # R + G + B
_SHEET_HEIGHT_PX, _SHEET_COLUMNS = 400, 4


@dataclass(frozen=True)
class Judged:
    """One picture: its mask and, where there are boxes, the shares."""

    name: str
    drawn: np.ndarray
    color: FloorColor
    field_floor: int
    field_px: int
    box_floor: int
    box_px: int
    num_boxes: int


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    parser.add_argument(
        "--images", required=True, metavar="DIR", type=Path, help="pictures, with .txt of boxes"
    )
    parser.add_argument(
        "--region", nargs=4, type=share, default=(0.0, 0.6, 1.0, 0.8), metavar="PART",
        help="left, top, right, bottom of a region that is mostly floor, in parts of the picture "
        "(default: 0 0.6 1 0.8, below the horizon of a camera that looks ahead)",
    )  # fmt: skip
    parser.add_argument(
        "--horizon", type=share, default=0.54, metavar="PART",
        help="boxes that end above it do not stand on the floor (default: 0.54)",
    )  # fmt: skip


def check(args: argparse.Namespace) -> None:
    """Refuse a folder without pictures and a region that is none."""
    if not pictures_in(args.images):
        raise UserError(f"--images {args.images}: no .jpg or .png there")
    left, top, right, bottom = args.region
    if not (0.0 <= left < right <= 1.0 and 0.0 <= top < bottom <= 1.0):
        raise UserError(f"--region must be left < right and top < bottom in 0..1: {args.region}")


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder, sorted."""
    return sorted(p for p in folder.glob("*") if p.suffix.lower() in (".jpg", ".png"))


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Label every picture, judge those with boxes, draw all."""
    values.update(dict.fromkeys(("box_floor_share", "field_floor_share", "images", "boxes")))
    judged, rows = [], []
    for path in pictures_in(args.images):
        try:
            one = judge(path, args)
        except ValueError as error:
            rows.append([path.stem, None, None, 0, str(error)])
            continue
        judged.append(one)
        rows.append([
            one.name, _share(one.field_floor, one.field_px), _share(one.box_floor, one.box_px),
            one.num_boxes, "",
        ])  # fmt: skip
    values["images"], values["learned"] = len(rows), len(judged)
    values["boxes"] = sum(one.num_boxes for one in judged)
    for key in ("field", "box"):
        floor = sum(getattr(one, f"{key}_floor") for one in judged)
        values[f"{key}_floor_share"] = _share(
            floor, sum(getattr(one, f"{key}_px") for one in judged)
        )
    values["per_image"] = {row[0]: {"field": row[1], "box": row[2]} for row in rows}
    header = ["picture", "field labelled floor", "boxes labelled floor", "boxes", "no result"]
    blocks: list[Any] = [_figures(values), Table(header, rows)]
    if judged:
        png = args.out_dir / "floor_images.png"
        cv2.imwrite(str(png), contact_sheet([one.drawn for one in judged]))
        blocks.append(Picture(png, "floor green, end of the free space red, boxes blue"))
    return [Section("Floor in real pictures", blocks)]


def judge(path: Path, args: argparse.Namespace) -> Judged:
    """Label one picture.

    Raises:
        ValueError: It cannot be read, or no color prevails in its region.
    """
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError("not a picture")
    scale = min(1.0, MAX_SIDE_PX / max(image.shape[:2]))
    image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    height, width = image.shape[:2]
    left, top, right, bottom = (
        round(p * s) for p, s in zip(args.region, (width, height) * 2, strict=True)
    )
    region = np.zeros((height, width), dtype=bool)
    region[top:bottom, left:right] = True
    region &= image.sum(axis=2) > BLACK
    color = learn(image[region][:, ::-1], ColorConfig(), ColorConfig().ring_share)
    mask = floor_mask(image, color, region)
    boxes = standing_boxes(path.with_suffix(".txt"), width, height, args.horizon)
    field = region.copy()
    for box in all_boxes(path.with_suffix(".txt"), width, height):
        field[box] = False
    middles = np.zeros_like(region)
    for box in boxes:
        middles[middle_of(box)] = True
    return Judged(
        path.stem, _drawn(image, mask, boxes, bottom), color,
        int((mask[field] > 0).sum()), int(field.sum()),
        int((mask[middles] > 0).sum()), int(middles.sum()), len(boxes),
    )  # fmt: skip


def floor_mask(image: np.ndarray, color: FloorColor, region: np.ndarray) -> np.ndarray:
    """Return the floor that hangs together with a region, 255 or 0, (H, W)."""
    height, width = region.shape
    spans = np.tile(np.array([0, width], dtype=np.int32), (height, 1))
    raw = np.zeros((height, width), dtype=np.uint8)
    classify(image, color_table(color, ColorConfig(), "bgr"), spans, np.zeros_like(raw), raw)
    closed = cv2.morphologyEx(raw, cv2.MORPH_CLOSE, np.ones((BRIDGE_PX, BRIDGE_PX), np.uint8))
    clean = cv2.morphologyEx(closed, cv2.MORPH_OPEN, np.ones((SPECK_PX, SPECK_PX), np.uint8))
    _, labels = cv2.connectedComponents(clean)
    inside = np.bincount(labels[region], minlength=labels.max() + 1)
    inside[0] = 0
    return np.where(inside[labels] > 0.02 * region.sum(), 255, 0).astype(np.uint8)


def column_template(height: int, width: int, bottom: int) -> PolarTemplate:
    """Return cells in columns from a row upwards; edges are rows above it."""
    rows, columns = np.mgrid[:height, :width]
    i = (bottom - 1 - rows) // CELL_ROWS
    num_rings = bottom // CELL_ROWS
    cells = columns * NUM_COLUMNS // width * num_rings + i
    cells[(i < 0) | (i >= num_rings)] = -1
    areas = np.bincount(cells[cells >= 0], minlength=NUM_COLUMNS * num_rings).astype(np.int32)
    edges = CELL_ROWS * np.arange(num_rings + 1, dtype=float)
    own = np.arange(len(areas), dtype=np.int32)
    return PolarTemplate(
        edges, NUM_COLUMNS, cells.astype(np.int32), areas, own, row_spans(cells >= 0)
    )


def contact_sheet(pictures: list[np.ndarray]) -> np.ndarray:
    """Return pictures side by side, as many to a row as fit a page."""
    sized = [
        cv2.resize(p, (round(p.shape[1] * _SHEET_HEIGHT_PX / p.shape[0]), _SHEET_HEIGHT_PX))
        for p in pictures
    ]
    width = max(p.shape[1] for p in sized)
    padded = [cv2.copyMakeBorder(p, 2, 2, 2, width - p.shape[1] + 2, 0) for p in sized]
    while len(padded) % _SHEET_COLUMNS and len(padded) > _SHEET_COLUMNS:
        padded.append(np.zeros_like(padded[0]))
    n = min(_SHEET_COLUMNS, len(padded))
    return np.vstack([np.hstack(padded[k : k + n]) for k in range(0, len(padded), n)])


def _drawn(image: np.ndarray, mask: np.ndarray, boxes: list[Any], bottom: int) -> np.ndarray:
    picture = image.copy()
    is_floor = mask > 0
    picture[is_floor] = (0.6 * picture[is_floor] + 0.4 * np.array((80, 255, 80))).astype(np.uint8)
    template = column_template(*mask.shape, bottom)
    share = TemplateConfig().free_share
    _, free = ratios_and_ranges(floor_areas(mask, template), template, share)
    wide = mask.shape[1] / NUM_COLUMNS
    for j, rows in enumerate(np.clip(free, 0.0, template.edges[-1])):
        a, b = (
            (round(j * wide), round(bottom - rows)),
            (round((j + 1) * wide), round(bottom - rows)),
        )
        cv2.line(picture, a, b, (40, 40, 255), 3)
    for rows, columns in boxes:
        cv2.rectangle(
            picture, (columns.start, rows.start), (columns.stop, rows.stop), (255, 120, 40), 2
        )
    return picture


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _figures(values: dict[str, Any]) -> Figures:
    def percent(value: float | None) -> str:
        return "-" if value is None else f"{100.0 * value:.1f} %"

    return Figures([
        ("of the field labelled floor", percent(values["field_floor_share"])),
        ("of obstacles and people labelled floor", percent(values["box_floor_share"])),
        ("pictures, with a color learned", f"{values['images']}, {values['learned']}"),
        ("boxes that stand on the floor", str(values["boxes"])),
    ])  # fmt: skip
