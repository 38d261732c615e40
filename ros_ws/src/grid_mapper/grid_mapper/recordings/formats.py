"""Tell the format of a recording by its content and open it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from grid_mapper.recordings.bag_events import open_bag_recording
from grid_mapper.recordings.bag_files import is_bag
from grid_mapper.recordings.carmen import CARMEN_KINDS, open_carmen
from grid_mapper.recordings.events import Recording, RecordingError, RecordingOptions
from grid_mapper.recordings.mines_rover import is_mines_rover, open_mines_rover
from grid_mapper.recordings.posegraph import open_posegraph
from grid_mapper.recordings.sonar_logs import (
    eight_sonars_file,
    is_sonar_ring,
    open_eight_sonars,
    open_sonar_ring,
)
from grid_mapper.recordings.text_lines import read_head, read_lines
from grid_mapper.recordings.wean_hall import is_wean_hall, open_wean_hall

Opener = Callable[[Path, RecordingOptions], Recording]
NUM_LINES_BEHIND = 20
SUPPORTED = (
    "rosbag2 (sqlite3 or mcap, compressed or not), ROS 1 bag, CARMEN log (FLASER, ROBOTLASER1,"
    " RAWLASER1), pose-graph log (VERTEX2, ROBOTLASER1, EDGE2), Wean Hall log (O, L), Mines rover"
    " log (707 columns), SCITOS ring of sonars (S1..S24 CSV), eight sonars (measurement.txt beside"
    " poses.txt); text logs plain or gzip"
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
    eight_sonars = eight_sonars_file(path)
    if eight_sonars is not None:
        return open_eight_sonars(eight_sonars, options)
    if is_bag(path):
        return open_bag_recording(path, options)
    opener = _log_opener(path)
    if opener is not None:
        return opener(path, options)
    raise RecordingError(f"{path} is of no known format; known are: {SUPPORTED}")


def is_log(path: Path) -> bool:
    """Tell by its first lines whether a file is a text log of a known kind."""
    try:
        head = read_head(path)
    except (RecordingError, OSError):
        return False
    lines = head.decode(errors="replace").splitlines()
    return b"\x00" not in head and any(
        words[0] == "VERTEX2" or _opener_of(words) for words in map(str.split, lines) if words
    )


def _log_opener(path: Path) -> Opener | None:
    """Return what reads a text log; None if no line of it is of a known kind.

    The first line of a known kind tells, but laser lines of a pose graph look as CARMEN's do: a
    VERTEX2 among the next lines tells them apart.
    """
    if b"\x00" in read_head(path):
        return None
    opener: Opener | None = None
    num_behind = 0
    for words in (line.split() for line in read_lines(path, lambda problem: None)):
        if words and words[0] == "VERTEX2":
            return open_posegraph
        opener = opener or (_opener_of(words) if words else None)
        num_behind += opener is not None
        if num_behind > NUM_LINES_BEHIND:
            break
    return opener


def _opener_of(words: list[str]) -> Opener | None:
    if words[0] in CARMEN_KINDS:
        return open_carmen
    if is_wean_hall(words):
        return open_wean_hall
    if is_sonar_ring(words):
        return open_sonar_ring
    return open_mines_rover if is_mines_rover(words) else None
