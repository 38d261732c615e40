"""A bag as topics and serialized messages in recorded order; rosbag2 or ROS 1, whole or cut off."""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import apsw
from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag1 import ReaderError as Ros1Error
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from grid_mapper.recordings.bag_files import (
    MCAP_MAGIC,
    ROS1_MAGIC,
    magic_of,
    storage_files,
    unpacked_message,
)
from grid_mapper.recordings.bag_metadata import metadata_qos
from grid_mapper.recordings.bag_salvage import salvage_reader
from grid_mapper.recordings.bag_types import BagTypes
from grid_mapper.recordings.events import RecordingError

STORAGE_ERRORS = (
    ReaderError, Ros1Error, apsw.Error, struct.error, EOFError, OSError, AssertionError,
    ValueError, IndexError, KeyError, TypeError,
)  # fmt: skip
"""What the storage readers raise on damaged files."""


class Message(NamedTuple):
    """A serialized message: topic, type, when it was recorded (ns) and its bytes."""

    topic: str
    msgtype: str
    recorded_ns: int
    data: bytes


@dataclass
class Topic:
    """A topic of a bag.

    Attributes:
        name: As recorded.
        msgtype: Such as `sensor_msgs/msg/LaserScan`.
        num_messages: In all files.
        qos: Profiles that its publishers offered; empty where not recorded.
        definition: Text of the message definition; empty where not recorded.
    """

    name: str
    msgtype: str
    num_messages: int = 0
    qos: list[Qos] = field(default_factory=list)
    definition: str = ""


class Storage(Protocol):
    """One storage file, as rosbags' readers and the ones for damaged files give it."""

    connections: list[Connection]

    def messages(
        self, connections: Collection[Connection], start: int | None = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield the messages of some connections in recorded order."""
        ...


class Bag:
    """An open bag; use as a context manager.

    Args:
        path: A storage file or a bag folder.

    Raises:
        RecordingError: If nothing in it can be read.
    """

    def __init__(self, path: Path) -> None:
        """Open all storage files."""
        self.path = path
        self.problems: list[str] = []
        self._stack = ExitStack()
        try:
            files = storage_files(path, self._stack)
            self.is_ros1 = magic_of(files[0]).startswith(ROS1_MAGIC)
            self._storages = [s for s in map(self._open, files) if s is not None]
        except BaseException:
            self._stack.close()
            raise
        if not self._storages:
            self._stack.close()
            raise RecordingError(f"{path} cannot be read: {'; '.join(self.problems)}")
        self._storages.sort(key=_start_ns)
        self.types = BagTypes((c for s in self._storages for c in s.connections), self.is_ros1)
        self.topics = self._collect_topics()

    def __enter__(self) -> Bag:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close all files."""
        self.close()

    def close(self) -> None:
        """Close all files and remove unpacked copies."""
        self._stack.close()

    @property
    def num_messages(self) -> int:
        """Messages in all topics."""
        return sum(topic.num_messages for topic in self.topics.values())

    @property
    def start_ns(self) -> int:
        """When the first message was recorded, ns; 0 if there is none."""
        return min((_start_ns(s) for s in self._storages if _end_ns(s) > 0), default=0)

    @property
    def duration_ns(self) -> int:
        """Time between first and last message, ns."""
        return max(max((_end_ns(s) - 1 for s in self._storages), default=0) - self.start_ns, 0)

    def messages(
        self, topics: Collection[str] | None = None, start_ns: int | None = None
    ) -> Iterator[Message]:
        """Yield messages in recorded order; a damaged file ends early and is noted in `problems`.

        Args:
            topics: Names of topics; None for all.
            start_ns: Leave out what was recorded earlier.
        """
        for storage in self._storages:
            wanted = [c for c in storage.connections if topics is None or c.topic in topics]
            if not wanted:
                continue
            num_read = 0
            try:
                for connection, stamp, data in storage.messages(wanted, start=start_ns):
                    yield Message(connection.topic, connection.msgtype, stamp, bytes(data))
                    num_read += 1
            except STORAGE_ERRORS as error:
                self._note(f"{self.path.name} is damaged after {num_read} messages: {error}")

    def deserialize(self, message: Message) -> Any:
        """Return the message object of a message.

        Raises:
            ValueError: If the bytes cannot be read as its type.
        """
        data = message.data if self.is_ros1 else unpacked_message(message.data)
        return self.types.deserialize(data, message.msgtype)

    def _note(self, problem: str) -> None:
        if problem not in self.problems:
            self.problems.append(problem)

    def _open(self, path: Path) -> Storage | None:
        """Open one storage file, or what can be saved of it; None if that is nothing."""
        try:
            reader = self._opened(_reader_of(path))
            # Without an index rosbags refuses messages that are out of order: read those ourselves.
            has_no_index = (
                isinstance(reader, McapReader) and reader.connections and not reader.chunks
            )
            return salvage_reader(path) if has_no_index else reader
        except STORAGE_ERRORS as error:
            reason = " ".join(str(error).split())
        name = self.path.name
        try:
            salvaged = salvage_reader(path)
        except STORAGE_ERRORS as error:
            self._note(f"nothing in {name} can be read ({reason}; {error})")
            return None
        self._note(
            f"{name} was not closed properly or is cut off ({reason}): {len(salvaged)} messages"
            f" are read, the last recorded at {(salvaged.metadata.end_time - 1) * 1e-9:.3f} s"
        )
        return salvaged

    def _opened(self, reader: Any) -> Storage:
        reader.open()
        self._stack.callback(reader.close)
        storage: Storage = reader
        return storage

    def _collect_topics(self) -> dict[str, Topic]:
        topics: dict[str, Topic] = {}
        recorded_qos = metadata_qos(self.path)
        for connection in (c for s in self._storages for c in s.connections):
            new = Topic(connection.topic, connection.msgtype, definition=connection.msgdef.data)
            topic = topics.setdefault(connection.topic, new)
            topic.num_messages += _num_messages(connection)
            for profile in _qos(connection) or recorded_qos.get(connection.topic, []):
                if profile not in topic.qos:
                    topic.qos.append(profile)
        return dict(sorted(topics.items()))


def _reader_of(path: Path) -> Any:
    magic = magic_of(path)
    if magic.startswith(ROS1_MAGIC):
        return Ros1Reader(path)
    return McapReader(path) if magic.startswith(MCAP_MAGIC) else Sqlite3Reader(path)


def _has_no_index(reader: Any) -> bool:
    """Tell of an mcap file that rosbags reads only if its messages are in order."""
    return isinstance(reader, McapReader) and bool(reader.connections) and not reader.chunks


def _start_ns(storage: Any) -> int:
    metadata = getattr(storage, "metadata", None)
    return int(storage.start_time if metadata is None else metadata.start_time)


def _end_ns(storage: Any) -> int:
    metadata = getattr(storage, "metadata", None)
    return int(storage.end_time if metadata is None else metadata.end_time)


def _num_messages(connection: Connection) -> int:
    if isinstance(connection.owner, Ros1Reader):
        chunks = connection.owner.chunk_infos
        return sum(chunk.connection_counts.get(connection.id, 0) for chunk in chunks)
    return connection.msgcount


def _qos(connection: Connection) -> list[Qos]:
    ext = connection.ext
    return ext.offered_qos_profiles if isinstance(ext, ConnectionExtRosbag2) else []
