"""Readers for storage files that were cut off; they go through a file from its start."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rosbags.rosbag2.errors import ReaderError


def salvage_reader(path: Path) -> Any:
    """Return a reader for a damaged file.

    Raises:
        ReaderError: If nothing is known to help.
    """
    raise ReaderError(f"{path.name} is damaged")
