"""Time from image to free space, stage by stage, beside bare OpenCV passes over the same image.

Floor: one look-up of three channels, one opening with a square of five pixels, one labelling; our
whole goes from the image to ranges, the floor's color followed; `fading` is the whole while the
lamp fades and comes back, so that the table of colors is made anew now and then. Peer: the usual
pipeline of OpenCV, that is color range, opening, closing, labelling with areas, and a histogram
over the cells. The last case is the node over DDS, from publishing an image to the arrival of its
scan.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from itertools import count
from pathlib import Path

import cv2
import numpy as np

from experiments.floor_scenes import scenes
from experiments.timing import Case, median_and_p99, take_turns
from floor_perception.color_table import color_table
from floor_perception.config import ColorConfig, FloorDetectorConfig, TemplateConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.free_space import floor_areas, ratios_and_ranges
from floor_perception.resources import load_camera_model

SIZES = ((256, 220), (640, 480), (1280, 960))
NUM_CALLS = 400
FRAME_NS = 33_333_333
NUM_LIGHTS, FRAMES_A_LIGHT, DIMMEST = 20, 10, 0.6
Calls = dict[str, Callable[[], object]]
DOMAIN = 59
PEER = "usual OpenCV pipeline"


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each size, and one for each of its stages."""
    cv2.setNumThreads(1)
    cases = []
    for width, height in SIZES:
        say(f"floor: {width} x {height}")
        image = next(scenes((width, height), 1, seed)).picture
        detector = FloorDetector(load_camera_model("soccer_small_size"), FloorDetectorConfig())
        detector.detect(image, "rgb", 0)
        stages, bare = _stages(detector, image), _bare(detector, image)
        stamps = (k * FRAME_NS for k in count(1))
        calls: Calls = {
            "whole": lambda d=detector, i=image, s=stamps: d.detect(i, "rgb", next(s)),
            "fading": _fading(image), "usual": _usual(detector, image), **stages, **bare,
        }  # fmt: skip
        cases += _cases(f"{width}x{height}", take_turns(calls, NUM_CALLS), stages, bare)
    say("floor: 640 x 480 over DDS at 30 Hz")
    return [*cases, _over_dds(seed)]


def _over_dds(seed: int) -> Case:
    """Time image in to free space out of the node, in a graph of its own."""
    picture = next(scenes((640, 480), 1, seed)).picture
    script = Path(__file__).with_name("floor_latency.py")
    env = {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.npy"
        np.save(path, picture)
        command = [sys.executable, str(script), str(path)]
        answer = subprocess.run(command, env=env, check=True, capture_output=True, text=True)
    found = json.loads(answer.stdout.splitlines()[-1])
    extra = {"lost": found["lost"], "images": found["images"]}
    return Case("640x480_over_dds", found["median_ms"], found["p99_ms"], extra=extra)


def _cases(size: str, ms: dict[str, np.ndarray], stages: Calls, bare: Calls) -> list[Case]:
    floor = sum(float(np.median(ms[name])) for name in bare)
    median, p99 = median_and_p99(ms["whole"])
    extra = {"times_the_floor": median / floor}
    extra |= {name: float(np.median(ms[name])) for name in bare}
    whole = Case(size, median, p99, PEER, float(np.median(ms["usual"])), floor, extra)
    names = ("fading", *stages)
    return [whole, *(Case(f"{size}_{name}", *median_and_p99(ms[name])) for name in names)]


def _fading(image: np.ndarray) -> Callable[[], object]:
    """Return the whole over a lamp that fades and comes back, in one light for a few frames."""
    lights = 0.5 * (1.0 + DIMMEST + (1.0 - DIMMEST) * np.cos(np.linspace(0, 2 * np.pi, NUM_LIGHTS)))
    pictures = [cv2.convertScaleAbs(image, alpha=light) for light in lights]
    detector = FloorDetector(load_camera_model("soccer_small_size"), FloorDetectorConfig())
    frames = count()

    def fading() -> object:
        k = next(frames)
        picture = pictures[k // FRAMES_A_LIGHT % NUM_LIGHTS]
        return detector.detect(picture, "rgb", k * FRAME_NS)

    return fading


def _stages(detector: FloorDetector, image: np.ndarray) -> Calls:
    """Return what the whole is made of; each stage begins from what the one before it made."""
    table = color_table(detector.color, ColorConfig())
    masker, template = detector.masker, detector.template
    mask = masker.mask(image, table)
    raw = masker.raw_mask(image, table)
    areas = floor_areas(mask, template)
    return {
        "color": lambda: masker.raw_mask(image, table),
        "morphology": lambda: masker.cleaned(raw),
        "cells": lambda: floor_areas(mask, template),
        "ranges": lambda: ratios_and_ranges(areas, template, TemplateConfig().free_share),
        "table anew": lambda: color_table(detector.color, ColorConfig()),
    }


def _bare(detector: FloorDetector, image: np.ndarray) -> Calls:
    table = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)[None]
    square = np.ones((5, 5), np.uint8)
    mask = detector.masker.mask(image, color_table(detector.color, ColorConfig()))
    return {
        "bare look-up": lambda: cv2.LUT(image, table),
        "bare opening": lambda: cv2.morphologyEx(mask, cv2.MORPH_OPEN, square),
        "bare labelling": lambda: cv2.connectedComponents(mask, ltype=cv2.CV_16U),
    }


def _usual(detector: FloorDetector, image: np.ndarray) -> Callable[[], object]:
    square, template = np.ones((5, 5), np.uint8), detector.template
    num_cells = len(template.areas)
    cells = template.cells.astype(np.float32)

    def usual() -> object:
        mask = cv2.inRange(image, (0, 60, 0), (80, 255, 110))
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, square)
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, square)
        cv2.connectedComponentsWithStats(mask)
        return cv2.calcHist([cells], [0], mask, [num_cells], [0, num_cells])

    return usual
