"""Tell the format of a recording by its content and open it."""

from __future__ import annotations

from pathlib import Path

from grid_mapper.recordings.bag_events import open_bag_recording
from grid_mapper.recordings.bag_files import is_bag
from grid_mapper.recordings.carmen import open_carmen
from grid_mapper.recordings.events import Recording, RecordingError, RecordingOptions
from grid_mapper.recordings.mines_rover import is_mines_rover, open_mines_rover
from grid_mapper.recordings.posegraph import open_posegraph
from grid_mapper.recordings.text_lines import read_head
from grid_mapper.recordings.wean_hall import is_wean_hall, open_wean_hall

SUPPORTED = (
    "rosbag2 (sqlite3 or mcap, compressed or not), ROS 1 bag, CARMEN log (FLASER, ROBOTLASER1),"
    " pose-graph log (VERTEX2, ROBOTLASER1, EDGE2), Wean Hall log (O, L), Mines rover log"
    " (707 columns); text logs plain or gzip"
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
    if path.is_file() and path.stat().st_size == 0:
        raise RecordingError(f"{path} is empty")
    if is_bag(path):
        return open_bag_recording(path, options)
    lines = _first_lines(path)
    kinds = {words[0] for words in lines}
    if "VERTEX2" in kinds:
        return open_posegraph(path, options)
    if kinds & {"FLASER", "ROBOTLASER1", "ODOM", "PARAM"}:
        return open_carmen(path, options)
    if any(is_wean_hall(words) for words in lines):
        return open_wean_hall(path, options)
    if any(is_mines_rover(words) for words in lines):
        return open_mines_rover(path, options)
    raise RecordingError(f"{path} is of no known format; known are: {SUPPORTED}")


def _first_lines(path: Path) -> list[list[str]]:
    """Return the lines at the start of a file as words; empty ones are left out."""
    text = read_head(path).decode("utf-8", errors="replace")
    return [words for line in text.splitlines() if (words := line.split())]
