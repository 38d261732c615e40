"""Which files of a folder are parts of one bag, and which are bags of their own."""

from __future__ import annotations

import re
from pathlib import Path

from grid_mapper.recordings.bag_metadata import metadata_files

PART_NAME = re.compile(r"(?P<base>.*?)_(?P<number>\d+)(?P<endings>(\.(db3|mcap|bag|zstd))*)")
DATE = re.compile(r"\d{4}(-\d\d){5}")
"""ROS 1 names each part by the time at which it was begun."""


def parts_of_one_bag(folder: Path, files: list[Path]) -> list[Path]:
    """Return the files of a folder that are one recording; none if they are several.

    These are the ones that metadata.yaml lists, or else all if their names tell it: one base
    and numbers from 0 on, as recorders split bags. Where ROS 1 kept only the last
    parts, their dates tell that they are such.
    """
    if len(files) < 2 or _are_numbered(files):
        return files
    listed = {Path(name).name for name in metadata_files(folder)}
    return [file for file in files if file.name in listed]


def _are_numbered(files: list[Path]) -> bool:
    matches = [PART_NAME.fullmatch(DATE.sub("", file.name)) for file in files]
    parts = [(m["base"], int(m["number"])) for m in matches if m is not None]
    numbers = sorted(number for _, number in parts)
    is_one = len(parts) == len(files) and len({base for base, _ in parts}) == 1
    is_dated = all(DATE.search(file.name) for file in files)
    start = numbers[0] if is_one and is_dated else 0
    return is_one and numbers == list(range(start, start + len(numbers)))
