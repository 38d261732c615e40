"""Tell the format of a recording by its content and open it."""

from __future__ import annotations

from pathlib import Path

from grid_mapper.recordings.bag_events import open_bag_recording
from grid_mapper.recordings.bag_files import is_bag
from grid_mapper.recordings.carmen import open_carmen
from grid_mapper.recordings.events import Recording, RecordingError, RecordingOptions
from grid_mapper.recordings.text_lines import read_head

SUPPORTED = (
    "rosbag2 (sqlite3 or mcap, compressed or not), ROS 1 bag, CARMEN log (FLASER, ROBOTLASER1)"
)


def open_recording(path: str | Path, options: RecordingOptions | None = None) -> Recording:
    """Open a recording of any supported format.

    Args:
        path: A file, or the folder of a rosbag2.
        options: What the user says about it; None leaves all to the recording.

    Returns:
        The open recording; take its events once.

    Raises:
        RecordingError: With one line that says what is missing and which option says it.
    """
    path = Path(path)
    options = options if options is not None else RecordingOptions()
    if not path.exists():
        raise RecordingError(f"{path} does not exist")
    if is_bag(path):
        return open_bag_recording(path, options)
    kinds = _line_kinds(path)
    if kinds & {"FLASER", "ROBOTLASER1", "ODOM", "PARAM"}:
        return open_carmen(path, options)
    raise RecordingError(f"{path} is of no known format; known are: {SUPPORTED}")


def _line_kinds(path: Path) -> set[str]:
    """Return the first words of the lines at the start of a file."""
    text = read_head(path).decode("utf-8", errors="replace")
    return {line.split(maxsplit=1)[0] for line in text.splitlines() if line.strip()}
