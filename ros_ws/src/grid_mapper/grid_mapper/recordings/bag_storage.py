"""One storage file of a bag: its reader, what that can raise, and its messages."""

from __future__ import annotations

import struct
import sys
import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol
from urllib.parse import quote

import apsw
from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag1 import ReaderError as Ros1Error
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from grid_mapper.recordings.bag_files import MCAP_MAGIC, ROS1_MAGIC, magic_of

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

ROS1_ENCODING = "ros1"
STORAGE_ERRORS = (
    ReaderError, Ros1Error, apsw.Error, struct.error, EOFError, OSError, AssertionError,
    ValueError, IndexError, KeyError, TypeError, RuntimeError, ArithmeticError, MemoryError,
    zstd.ZstdError, zlib.error,
)  # fmt: skip
"""What the storage readers raise on damaged files."""


class Message(NamedTuple):
    """A serialized message: topic, type, when it was recorded (ns) and its bytes."""

    topic: str
    msgtype: str
    recorded_ns: int
    data: bytes


class Storage(Protocol):
    """One storage file, as rosbags' readers and the ones for damaged files give it."""

    connections: list[Connection]

    def messages(
        self, connections: Collection[Connection], start: int | None = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield the messages of some connections in recorded order."""
        ...


def stored_messages(
    storage: Storage, topics: Collection[str] | None, start_ns: int | None
) -> Iterator[Message]:
    """Yield the messages of some topics (None: all) recorded from a time on, in order."""
    wanted = [c for c in storage.connections if topics is None or c.topic in topics]
    if wanted:
        for connection, stamp, data in storage.messages(wanted, start=start_ns):
            yield Message(connection.topic, connection.msgtype, stamp, bytes(data))


def num_wanted(storage: Storage, topics: Collection[str] | None) -> int:
    """Return how many messages of some topics its index promises."""
    wanted = [c for c in storage.connections if topics is None or c.topic in topics]
    return sum(map(num_messages_of, wanted))


def reader_of(path: Path) -> Any:
    """Return the reader for a file, not opened yet; sqlite reads its path as a URI."""
    magic = magic_of(path)
    if magic.startswith(ROS1_MAGIC):
        return Ros1Reader(path)
    if magic.startswith(MCAP_MAGIC):
        return McapReader(path)
    return Sqlite3Reader(Path(quote(str(path))))


def reason_of(error: Exception) -> str:
    """Return an error as one line, without the path that sqlite's begin with."""
    return " ".join(str(error).split()).rpartition(": ")[2].strip("(',)")


def is_ros1(storage: Storage) -> bool:
    """Tell whether its messages are serialized as ROS 1 does; mcap files may hold such too."""
    exts = [connection.ext for connection in storage.connections]
    return any(
        not isinstance(ext, ConnectionExtRosbag2) or ext.serialization_format == ROS1_ENCODING
        for ext in exts
    )


def start_ns_of(storage: Any) -> int:
    """Return when its first message was recorded, ns."""
    metadata = getattr(storage, "metadata", None)
    return int(storage.start_time if metadata is None else metadata.start_time)


def end_ns_of(storage: Any) -> int:
    """Return the time behind its last message, ns; 0 if there is none."""
    metadata = getattr(storage, "metadata", None)
    return int(storage.end_time if metadata is None else metadata.end_time)


def num_messages_of(connection: Connection) -> int:
    """Return how many messages a topic has in its file."""
    if isinstance(connection.owner, Ros1Reader):
        chunks = connection.owner.chunk_infos
        return sum(chunk.connection_counts.get(connection.id, 0) for chunk in chunks)
    return connection.msgcount


def qos_of(connection: Connection) -> list[Qos]:
    """Return the profiles that were recorded with a topic."""
    ext = connection.ext
    return ext.offered_qos_profiles if isinstance(ext, ConnectionExtRosbag2) else []
