"""Go through an mcap file record by record, without its index; see mcap.dev/spec."""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from io import SEEK_END, BytesIO
from pathlib import Path
from typing import BinaryIO

from lz4.frame import LZ4FrameDecompressor
from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag2,
    MessageDefinition,
    MessageDefinitionFormat,
)
from rosbags.rosbag2.metadata import parse_qos
from rosbags.typesys.msg import normalize_msgtype

from grid_mapper.recordings.bag_files import MCAP_MAGIC

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F
RECORD_HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<HIQQ")
CHUNK_HEAD_BYTES = 28
"""Start and end time, size, checksum."""
FORMATS = {
    "ros1msg": MessageDefinitionFormat.MSG,
    "ros2msg": MessageDefinitionFormat.MSG,
    "ros2idl": MessageDefinitionFormat.IDL,
}


class Fields:
    """Reads the fields of one record in order."""

    def __init__(self, data: bytes) -> None:
        """Start at the first field."""
        self._data = data
        self._at = 0

    def number(self, code: str) -> int:
        """Return a little-endian integer by its struct code."""
        size = struct.calcsize(code)
        value: int = struct.unpack_from(f"<{code}", self._data, self._at)[0]
        self._at += size
        return value

    def data(self, length_code: str = "I") -> bytes:
        """Return bytes that their length stands before."""
        size = self.number(length_code)
        self._at += size
        return self._data[self._at - size : self._at]

    def text(self) -> str:
        """Return a string that its length stands before."""
        return self.data().decode("utf-8", errors="replace")

    def skip(self, num_bytes: int) -> None:
        """Go on behind some bytes."""
        self._at += num_bytes

    def rest(self) -> bytes:
        """Return what is left."""
        return self._data[self._at :]


@dataclass
class Ending:
    """Whether the end of a file's data was reached, and something in it could not be read."""

    is_reached: bool = False
    is_broken: bool = False


def scan_mcap(
    path: Path, connections: list[Connection], ending: Ending
) -> Iterator[tuple[int, int, bytes]]:
    """Yield channel id, log time (ns) and bytes of each message until the file ends or breaks.

    Args:
        path: An mcap file.
        connections: Channels are added as they are met.
        ending: Noted when the data's end is reached.
    """
    schemas: dict[int, tuple[str, MessageDefinition]] = {}
    with path.open("rb") as stream:
        stream.seek(len(MCAP_MAGIC))
        for code, data in _records(stream, ending):
            if code in (DATA_END, FOOTER):
                ending.is_reached = True
                return
            try:
                inner = (
                    _records(BytesIO(_unpacked(data)), ending) if code == CHUNK else [(code, data)]
                )
            except (struct.error, zstd.ZstdError, RuntimeError, ValueError):
                ending.is_broken = True
                return
            for inner_code, inner_data in inner:
                fields = Fields(inner_data)
                if inner_code == SCHEMA:
                    _add_schema(fields, schemas)
                elif inner_code == CHANNEL:
                    _add_channel(fields, schemas, connections)
                elif inner_code == MESSAGE:
                    channel, _, log_time, _ = MESSAGE_HEAD.unpack_from(inner_data)
                    yield channel, log_time, inner_data[MESSAGE_HEAD.size :]


def _records(stream: BinaryIO, ending: Ending) -> Iterator[tuple[int, bytes]]:
    """Yield code and content of each complete record, and of a chunk that is cut off."""
    begin = stream.tell()
    end = stream.seek(0, SEEK_END)
    stream.seek(begin)
    while len(head := stream.read(RECORD_HEAD.size)) == RECORD_HEAD.size:
        code, size = RECORD_HEAD.unpack(head)
        data = stream.read(min(size, end))
        ending.is_broken |= len(data) < size
        if len(data) < size and code != CHUNK:
            return
        yield code, data


def _unpacked(chunk: bytes) -> bytes:
    """Return the records of a chunk, or the first of them if it is cut off."""
    fields = Fields(chunk)
    fields.skip(CHUNK_HEAD_BYTES)
    compression = fields.text()
    content = fields.data("Q")
    if compression == "zstd":
        return zstd.ZstdDecompressor().decompress(content)
    if compression == "lz4":
        return bytes(LZ4FrameDecompressor().decompress(content))
    return content


def _add_schema(fields: Fields, schemas: dict[int, tuple[str, MessageDefinition]]) -> None:
    number, name, encoding, text = fields.number("H"), fields.text(), fields.text(), fields.text()
    kind = FORMATS.get(encoding, MessageDefinitionFormat.NONE)
    schemas[number] = (normalize_msgtype(name), MessageDefinition(kind, text))


def _add_channel(
    fields: Fields,
    schemas: dict[int, tuple[str, MessageDefinition]],
    connections: list[Connection],
) -> None:
    number, schema = fields.number("H"), fields.number("H")
    topic, encoding = fields.text(), fields.text()
    if any(connection.id == number for connection in connections):
        return
    unknown = ("", MessageDefinition(MessageDefinitionFormat.NONE, ""))
    msgtype, definition = schemas.get(schema, unknown)
    pairs = Fields(fields.data())
    metadata: dict[str, str] = {}
    while pairs.rest():
        key = pairs.text()
        metadata[key] = pairs.text()
    ext = ConnectionExtRosbag2(encoding, parse_qos(metadata.get("offered_qos_profiles", "")))
    connections.append(Connection(number, topic, msgtype, definition, "", 0, ext, None))
