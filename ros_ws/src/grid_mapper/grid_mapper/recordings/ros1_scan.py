"""Go through a ROS 1 bag (format 2.0) record by record, without its index."""

from __future__ import annotations

import bz2
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from lz4.frame import LZ4FrameDecompressor
from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag1,
    MessageDefinition,
    MessageDefinitionFormat,
)
from rosbags.typesys.msg import normalize_msgtype

MESSAGE, CHUNK, CONNECTION = 2, 5, 7
SIZE = struct.Struct("<I")
TIME = struct.Struct("<II")


def scan_ros1(path: Path, connections: list[Connection]) -> Iterator[tuple[int, int, bytes]]:
    """Yield connection id, recorded time (ns) and bytes of each message until the file breaks.

    Args:
        path: A ROS 1 bag.
        connections: Connections are added as they are met.
    """
    with path.open("rb") as stream:
        stream.readline()
        for header, data in _records(stream):
            if header.get("op") != bytes([CHUNK]):
                continue
            try:
                content = _unpacked(header, data)
            except (OSError, RuntimeError, ValueError):
                return
            for inner, inner_data in _records(BytesIO(content)):
                code = inner.get("op", b"\x00")[0]
                if code == CONNECTION:
                    _add_connection(inner, inner_data, connections)
                elif code == MESSAGE:
                    seconds, nanoseconds = TIME.unpack(inner["time"])
                    (number,) = SIZE.unpack(inner["conn"])
                    yield number, seconds * 1_000_000_000 + nanoseconds, inner_data


def _records(stream: BinaryIO) -> Iterator[tuple[dict[str, bytes], bytes]]:
    """Yield header fields and content of each complete record, and of a chunk that is cut off."""
    while (header := _sized(stream)) is not None:
        fields = _fields(header)
        data = _sized(stream, may_be_cut=fields.get("op") == bytes([CHUNK]))
        if data is None:
            return
        yield fields, data


def _sized(stream: BinaryIO, may_be_cut: bool = False) -> bytes | None:
    """Return bytes that their size stands before; None if they are not all there."""
    head = stream.read(SIZE.size)
    if len(head) < SIZE.size:
        return None
    (size,) = SIZE.unpack(head)
    data = stream.read(size)
    return data if may_be_cut or len(data) == size else None


def _fields(header: bytes) -> dict[str, bytes]:
    fields: dict[str, bytes] = {}
    stream = BytesIO(header)
    while (field := _sized(stream)) is not None:
        name, _, value = field.partition(b"=")
        fields[name.decode("ascii", errors="replace")] = value
    return fields


def _unpacked(header: dict[str, bytes], data: bytes) -> bytes:
    compression = header.get("compression", b"none")
    if compression == b"bz2":
        return bz2.BZ2Decompressor().decompress(data)
    return bytes(LZ4FrameDecompressor().decompress(data)) if compression == b"lz4" else data


def _add_connection(header: dict[str, bytes], data: bytes, connections: list[Connection]) -> None:
    (number,) = SIZE.unpack(header["conn"])
    if any(connection.id == number for connection in connections):
        return
    fields = _fields(data)
    text = fields.get("message_definition", b"").decode("utf-8", errors="replace")
    connections.append(
        Connection(
            number,
            header["topic"].decode("utf-8", errors="replace"),
            normalize_msgtype(fields["type"].decode("utf-8", errors="replace")),
            MessageDefinition(MessageDefinitionFormat.MSG, text),
            fields.get("md5sum", b"").decode("ascii", errors="replace"),
            0,
            ConnectionExtRosbag1(None, None),
            None,
        )
    )
