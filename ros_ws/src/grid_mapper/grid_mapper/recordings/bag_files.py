"""The storage files of a bag, whatever their names, compression and state.

`metadata.yaml` is not needed: topics, types, QoS and counts are read from the files themselves.
It is read only for QoS profiles that the files of old bags do not hold.
"""

from __future__ import annotations

import shutil
import sys
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from grid_mapper.recordings.events import RecordingError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

SQLITE_MAGIC = b"SQLite format 3\x00"
MCAP_MAGIC = b"\x89MCAP0\r\n"
ROS1_MAGIC = b"#ROSBAG V"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
STORAGE_MAGICS = (SQLITE_MAGIC, MCAP_MAGIC, ROS1_MAGIC)
METADATA_NAME = "metadata.yaml"


def is_bag(path: Path) -> bool:
    """Tell whether a file or folder is a bag, by content."""
    if path.is_dir():
        return True
    return any(magic_of(path).startswith(magic) for magic in (*STORAGE_MAGICS, ZSTD_MAGIC))


def magic_of(path: Path) -> bytes:
    """Return the first bytes of a file."""
    with path.open("rb") as stream:
        return stream.read(16)


def storage_files(path: Path, stack: ExitStack) -> list[Path]:
    """Return the uncompressed storage files of a bag.

    Args:
        path: A storage file, or a folder that holds some.
        stack: Removes unpacked copies of compressed files when it is closed.

    Raises:
        RecordingError: If there is none.
    """
    found = sorted(path.iterdir()) if path.is_dir() else [path]
    files = [f for f in found if f.is_file() and is_bag(f) and f.stat().st_size > 0]
    if not files:
        raise RecordingError(
            f"{path} holds no recording: no sqlite3, mcap or ROS 1 bag file with anything in it"
        )
    return [_unpacked(f, stack) if magic_of(f).startswith(ZSTD_MAGIC) else f for f in files]


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
