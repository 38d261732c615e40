"""The storage files of a bag, whatever their names, compression and state.

`metadata.yaml` is not needed: topics, types, QoS and counts are read from the files themselves.
It is read only for QoS profiles that the files of old bags do not hold, and for which of several
files are one bag.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from grid_mapper.recordings.bag_metadata import METADATA_NAME
from grid_mapper.recordings.bag_parts import parts_of_one_bag
from grid_mapper.recordings.events import RecordingError
from grid_mapper.recordings.text_lines import read_head

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

SQLITE_MAGIC = b"SQLite format 3\x00"
MCAP_MAGIC = b"\x89MCAP0\r\n"
ROS1_MAGIC = b"#ROSBAG V"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
STORAGE_MAGICS = (SQLITE_MAGIC, MCAP_MAGIC, ROS1_MAGIC)
STORAGE_ENDINGS = (".db3", ".mcap", ".bag", ".db3.zstd", ".mcap.zstd")
NUM_NAMED = 5
NUM_BAGS_NAMED = 10
NUM_LEVELS = 2


def is_bag(path: Path) -> bool:
    """Tell whether a file or folder is a bag, by content."""
    return path.is_dir() or path.name == METADATA_NAME or _is_storage(path)


def _is_storage(path: Path) -> bool:
    magics = (*STORAGE_MAGICS, ZSTD_MAGIC)
    return path.is_file() and any(magic_of(path).startswith(magic) for magic in magics)


def magic_of(path: Path) -> bytes:
    """Return the first bytes of a file."""
    with path.open("rb") as stream:
        return stream.read(16)


def storage_files(path: Path, stack: ExitStack, note: Callable[[str], None]) -> list[Path]:
    """Return the storage files of a bag, each as one file that can be read as it is.

    Args:
        path: A storage file, or a folder that holds some.
        stack: Removes unpacked copies when it is closed.
        note: Told of files that hold nothing.

    Raises:
        RecordingError: If there is none, or the folder holds several bags.
    """
    found = sorted(path.iterdir()) if path.is_dir() else [path]
    named = [f for f in found if f.is_file() and f.name.endswith(STORAGE_ENDINGS)]
    for empty in (f for f in named if f.stat().st_size == 0):
        note(f"{empty.name} is empty")
    files = [f for f in found if _is_storage(f)]
    if not files:
        raise RecordingError(_nothing_in(path, found))
    parts = parts_of_one_bag(path, files)
    if not parts:
        names = _listed([f.name for f in files])
        raise RecordingError(f"{path} holds several bags: name one of the files in it: {names}")
    return [_readable(f, stack) for f in parts]


def _nothing_in(path: Path, found: list[Path]) -> str:
    text = f"{path} holds no recording: no sqlite3, mcap or ROS 1 bag file with anything in it"
    if not path.is_dir() and _is_text(path):
        return f"{path} is no bag: text logs cannot be replayed, map them with map_bag"
    inside = [str(f.relative_to(path)) for f in _bags_below(path, NUM_LEVELS)]
    if inside:
        return f"{text}; name one of the bags in it: {_listed(inside)}"
    from grid_mapper.recordings.formats import is_log  # which reads bags too

    logs = [f.name for f in found if f.is_file() and is_log(f)]
    return f"{text}; name a file if it is a log: {', '.join(logs[:NUM_NAMED])}" if logs else text


def _is_text(path: Path) -> bool:
    head = read_head(path)
    return bool(head) and b"\x00" not in head


def _bags_below(folder: Path, num_levels: int) -> list[Path]:
    """Return the bags in the folders of a folder: folders that are one, and files on their own."""
    if not folder.is_dir():
        return []
    bags: list[Path] = []
    for inner in sorted(f for f in folder.iterdir() if f.is_dir() and os.access(f, os.R_OK)):
        files = [f for f in sorted(inner.iterdir()) if f.name.endswith(STORAGE_ENDINGS)]
        files = [f for f in files if _is_storage(f)]
        if files:
            bags.extend([inner] if parts_of_one_bag(inner, files) else files)
        if num_levels > 1:
            bags.extend(_bags_below(inner, num_levels - 1))
    return bags


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - NUM_BAGS_NAMED} more" if len(names) > NUM_BAGS_NAMED else ""
    return ", ".join(names[:NUM_BAGS_NAMED]) + more


def _readable(path: Path, stack: ExitStack) -> Path:
    """Return the file, or a copy with what compression or a crash kept out of it."""
    magic = magic_of(path)
    if magic.startswith(ZSTD_MAGIC):
        return _unpacked(path, stack)
    beside = [f for f in map(path.with_name, _left_beside(path)) if _has_content(f)]
    if magic.startswith(SQLITE_MAGIC) and beside:
        return _merged(path, beside, stack)
    return path


def _left_beside(path: Path) -> list[str]:
    """Return the names under which sqlite leaves what it has not merged yet."""
    return [f"{path.name}-wal", f"{path.name}-journal"]


def _has_content(path: Path) -> bool:
    return path.is_file() and path.stat().st_size > 0


def _merged(path: Path, beside: list[Path], stack: ExitStack) -> Path:
    """Return a copy into which sqlite has merged what a recorder that was killed left beside it."""
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="floornav-bag-")))
    copies = [folder / f.name for f in (path, *beside)]
    for source, copy in zip((path, *beside), copies, strict=True):
        shutil.copyfile(source, copy)
    try:
        database = sqlite3.connect(copies[0])
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        database.execute("PRAGMA journal_mode=DELETE").fetchall()
        database.close()
    except sqlite3.Error:
        pass  # the reader of the copy finds it damaged and says so
    return copies[0]


def _unpacked(path: Path, stack: ExitStack) -> Path:
    """Return an unpacked copy of a zstd file; of a damaged one as much as can be read."""
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="floornav-bag-")))
    target = folder / (path.stem or path.name)
    with path.open("rb") as raw, target.open("wb") as out:
        try:
            with zstd.open(raw, "rb") as stream:
                shutil.copyfileobj(stream, out)
        except (EOFError, zstd.ZstdError):
            pass  # the reader of the copy finds it cut off and says so
    return target


def unpacked_message(data: bytes) -> bytes:
    """Return a message unpacked if it was compressed on its own (CDR never starts like that)."""
    return zstd.decompress(data) if data[:4] == ZSTD_MAGIC else data
