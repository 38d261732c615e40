"""A bag as topics and serialized messages in recorded order; rosbag2 or ROS 1, whole or cut off."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from rosbags.interfaces import Qos
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.storage_mcap import McapReader

from grid_mapper.recordings.bag_files import storage_files, unpacked_message
from grid_mapper.recordings.bag_metadata import METADATA_NAME, metadata_files, metadata_qos
from grid_mapper.recordings.bag_salvage import SalvageReader, salvage_reader
from grid_mapper.recordings.bag_storage import (
    STORAGE_ERRORS,
    Message,
    Storage,
    end_ns_of,
    is_ros1,
    num_messages_of,
    num_wanted,
    qos_of,
    reader_of,
    reason_of,
    start_ns_of,
    stored_messages,
)
from grid_mapper.recordings.bag_types import BagTypes
from grid_mapper.recordings.events import RecordingError

__all__ = ["Bag", "Message", "Topic"]


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


class Bag:
    """An open bag; use as a context manager.

    Args:
        path: A storage file or a bag folder.

    Raises:
        RecordingError: If nothing in it can be read.
    """

    def __init__(self, path: Path) -> None:
        """Open all storage files."""
        path = path.parent if path.name == METADATA_NAME else path
        self.path = path
        self.problems: list[str] = []
        self._stack = ExitStack()
        try:
            files = storage_files(path, self._stack, self._note)
            self._note_missing(len(files))
            opened = [(s, f) for f in files if (s := self._open(f)) is not None]
        except BaseException:
            self._stack.close()
            raise
        if not opened:
            self._stack.close()
            raise RecordingError(f"{path} cannot be read: {'; '.join(self.problems)}")
        opened.sort(key=lambda pair: start_ns_of(pair[0]))
        self._storages = [storage for storage, _ in opened]
        self._files = [file for _, file in opened]
        self.is_ros1 = any(is_ros1(s) for s in self._storages)
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
        return min((start_ns_of(s) for s in self._storages if end_ns_of(s) > 0), default=0)

    @property
    def duration_ns(self) -> int:
        """Time between first and last message, ns."""
        return max(max((end_ns_of(s) - 1 for s in self._storages), default=0) - self.start_ns, 0)

    def messages(
        self, topics: Collection[str] | None = None, start_ns: int | None = None
    ) -> Iterator[Message]:
        """Yield messages in recorded order; a damaged file ends early and is noted in `problems`.

        Args:
            topics: Names of topics; None for all.
            start_ns: Leave out what was recorded earlier.
        """
        for i in range(len(self._storages)):
            num_read = 0
            try:
                for message in stored_messages(self._storages[i], topics, start_ns):
                    yield message
                    num_read += 1
                num_missing = num_wanted(self._storages[i], topics) - num_read
                if start_ns is None and num_missing > 0:
                    raise ReaderError(f"{num_missing} messages are not where its index says")
            except STORAGE_ERRORS as error:
                if self._save(i, reason_of(error)):
                    saved = stored_messages(self._storages[i], topics, start_ns)
                    yield from islice(saved, num_read, None)

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

    def _save(self, i: int, reason: str) -> bool:
        """Read a storage that turns out to be damaged from its start instead; False if in vain."""
        if isinstance(self._storages[i], SalvageReader):
            return False
        saved = self._salvaged(self._files[i], reason)
        if saved is not None:
            self._storages[i] = saved
        return saved is not None

    def _note_missing(self, num_files: int) -> None:
        named = metadata_files(self.path) if self.path.is_dir() else []
        if len(named) > num_files:
            self._note(f"{METADATA_NAME} names {len(named)} files, {num_files} are there to read")

    def _open(self, path: Path) -> Storage | None:
        """Open one storage file, or what can be saved of it; None if that is nothing."""
        try:
            reader = self._opened(reader_of(path))
            # Without an index rosbags refuses messages that are out of order: read those ourselves.
            has_no_index = (
                isinstance(reader, McapReader) and reader.connections and not reader.chunks
            )
            if not has_no_index:
                return reader
            reason = "it has no index"
        except STORAGE_ERRORS as error:
            reason = reason_of(error)
        return self._salvaged(path, reason)

    def _salvaged(self, path: Path, reason: str) -> SalvageReader | None:
        """Return what can be read of a file from its start on, and note what that is."""
        name = self.path.name
        try:
            salvaged = salvage_reader(path)
        except STORAGE_ERRORS as error:
            self._note(f"nothing in {name} can be read ({reason}; {error})")
            return None
        if salvaged.is_whole:
            return salvaged
        self._note(
            f"{name} was not closed properly, is cut off or damaged ({reason}):"
            f" {len(salvaged)} messages"
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
            topic.num_messages += num_messages_of(connection)
            for profile in qos_of(connection) or recorded_qos.get(connection.topic, []):
                if profile not in topic.qos:
                    topic.qos.append(profile)
        return dict(sorted(topics.items()))
