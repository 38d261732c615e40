"""Readers for storage files that were cut off or never closed: they go through from the start.

They offer what rosbags' own readers do (`connections`, `messages`, start and end), at the cost of
reading the file once more, and end where it can no longer be read.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    MessageDefinition,
    MessageDefinitionFormat,
)
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import parse_qos

from grid_mapper.recordings.bag_files import MCAP_MAGIC, ROS1_MAGIC, magic_of
from grid_mapper.recordings.mcap_scan import FORMATS, Ending, scan_mcap
from grid_mapper.recordings.ros1_scan import scan_ros1

Record = tuple[int, int, bytes]
"""Connection id, recorded time (ns), bytes."""


class Span(NamedTuple):
    """First recorded time and the one behind the last, ns; as rosbags' readers have it."""

    start_time: int
    end_time: int


class SalvageReader:
    """What can be read of a damaged file, in recorded order.

    Args:
        connections: Its topics; filled while records are read.
        records: All that can be read, once; kept in memory.
        ending: Tells after reading whether the file came to its end; None if it cannot.

    Attributes:
        is_whole: Whether nothing is missing: the file only has no index.
    """

    def __init__(
        self,
        connections: list[Connection],
        records: Iterable[Record],
        ending: Ending | None = None,
    ) -> None:
        """Read everything that can be read."""
        self._records = sorted(records, key=lambda record: record[1])
        self.is_whole = ending is not None and ending.is_reached and not ending.is_broken
        if not self._records:
            raise ReaderError("no complete message in it")
        counts: dict[int, int] = {}
        for connection_id, _, _ in self._records:
            counts[connection_id] = counts.get(connection_id, 0) + 1
        self.connections = [c._replace(msgcount=counts.get(c.id, 0)) for c in connections]
        self.metadata = Span(self._records[0][1], self._records[-1][1] + 1)

    def __len__(self) -> int:
        """Return how many messages can be read."""
        return len(self._records)

    def messages(
        self,
        connections: Collection[Connection],
        start: int | None = None,
        stop: int | None = None,
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield the messages of some connections recorded from `start` to before `stop`, ns."""
        wanted = {connection.id: connection for connection in connections}
        for connection_id, recorded_ns, data in self._records:
            is_inside = (start is None or recorded_ns >= start) and (
                stop is None or recorded_ns < stop
            )
            if is_inside and connection_id in wanted:
                yield wanted[connection_id], recorded_ns, data


def salvage_reader(path: Path) -> SalvageReader:
    """Return a reader for a damaged file.

    Raises:
        ReaderError: If not one message can be read.
    """
    magic = magic_of(path)
    connections: list[Connection] = []
    if magic.startswith(MCAP_MAGIC):
        ending = Ending()
        return SalvageReader(connections, scan_mcap(path, connections, ending), ending)
    scan = scan_ros1 if magic.startswith(ROS1_MAGIC) else scan_sqlite3
    return SalvageReader(connections, scan(path, connections))


def scan_sqlite3(path: Path, connections: list[Connection]) -> Iterator[Record]:
    """Yield the rows of a cut-off rosbag2 database until one cannot be read.

    `writable_schema` makes sqlite open a file that is shorter than its header says.
    """
    database = sqlite3.connect(f"file:{quote(str(path))}?mode=ro&immutable=1", uri=True)
    try:
        database.execute("PRAGMA writable_schema=ON")
        columns = [row[1] for row in database.execute("PRAGMA table_info(topics)")]
        qos_column = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
        definitions = _definitions(database)
        rows = database.execute(f"SELECT id, name, type, {qos_column} FROM topics")
        connections.extend(_connection(definitions, *row) for row in rows)
        query = "SELECT topic_id, timestamp, data FROM messages ORDER BY id"
        for topic_id, recorded_ns, data in database.execute(query):
            if not (isinstance(recorded_ns, int) and isinstance(data, bytes)):
                return  # a page behind the end of the file reads as zeros
            yield topic_id, recorded_ns, data
    except sqlite3.Error:
        return
    finally:
        database.close()


def _definitions(database: sqlite3.Connection) -> dict[str, MessageDefinition]:
    """Return the definitions that bags since Iron hold, by type."""
    query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
    try:
        return {
            name: MessageDefinition(FORMATS[encoding], text)
            for name, encoding, text in database.execute(query)
            if encoding in FORMATS
        }
    except sqlite3.Error:
        return {}


def _connection(
    definitions: dict[str, MessageDefinition], topic_id: int, name: str, msgtype: str, qos: str
) -> Connection:
    definition = definitions.get(msgtype, MessageDefinition(MessageDefinitionFormat.NONE, ""))
    ext = ConnectionExtRosbag2("cdr", parse_qos(qos))
    return Connection(topic_id, name, msgtype, definition, "", 0, ext, None)
