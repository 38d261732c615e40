"""Deserialize the few message types that mapping reads, by the definitions in the bag."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any

from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.serde import SerdeError
from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)

SCAN_TYPE = "sensor_msgs/msg/LaserScan"
RANGE_TYPE = "sensor_msgs/msg/Range"
ODOM_TYPE = "nav_msgs/msg/Odometry"
TF_TYPE = "tf2_msgs/msg/TFMessage"
OLD_TF_TYPE = "tf/msg/tfMessage"
"""Of ROS 1 before 2013; the same layout."""
TEXT_TYPE = "std_msgs/msg/String"
ECHO_TYPE = "sensor_msgs/msg/MultiEchoLaserScan"
BAD_BYTES = (
    SerdeError, KeyError, IndexError, AssertionError, ValueError, TypeError, struct.error,
    ArithmeticError, MemoryError,
)  # fmt: skip
"""What reading bytes as a type that they are not raises."""
READ_TYPES = (SCAN_TYPE, RANGE_TYPE, ODOM_TYPE, TF_TYPE, OLD_TF_TYPE, TEXT_TYPE)
IDL_SEPARATOR = "=" * 80 + "\n"


class BagTypes:
    """Turns serialized bytes into message objects.

    Definitions stored in the bag win, for types change between distributions. A sqlite3 bag
    without any is older than Iron, so Humble's are taken. Types nobody reads are never looked at.

    Args:
        connections: Of the bag's files.
        is_ros1: Whether it is a ROS 1 bag.
    """

    def __init__(self, connections: Iterable[Connection], is_ros1: bool) -> None:
        """Collect the definitions."""
        self._is_ros1 = is_ros1
        self._defined: set[str] = set()
        self._newer = get_typestore(Stores.ROS2_JAZZY)
        self._store = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
        for connection in connections:
            if connection.msgtype in READ_TYPES:
                self._register(connection)

    def deserialize(self, data: bytes, msgtype: str) -> Any:
        """Return the message.

        Raises:
            ValueError: If the bytes are not such a message.
        """
        try:
            if self._is_ros1:
                return self._store.deserialize_ros1(data, msgtype)
            return self._deserialize_cdr(data, msgtype)
        except BAD_BYTES as error:
            raise ValueError(f"not a {msgtype}: {error}") from error

    def _deserialize_cdr(self, data: bytes, msgtype: str) -> Any:
        """Read by the definition; where the bag holds none, the newer one is tried as well."""
        try:
            return self._store.deserialize_cdr(data, msgtype)
        except BAD_BYTES:
            if msgtype in self._defined:
                raise
            return self._newer.deserialize_cdr(data, msgtype)

    def _register(self, connection: Connection) -> None:
        definition = connection.msgdef
        types: dict[str, Any] = {}
        try:
            if definition.format == MessageDefinitionFormat.MSG:
                types = get_types_from_msg(definition.data, connection.msgtype)
            elif definition.format == MessageDefinitionFormat.IDL:
                types = _types_from_idl(definition.data)
        except TypesysError:
            return  # an unreadable definition: the standard one is tried
        for name in types:
            self._store.fielddefs.pop(name, None)
        self._store.register(types)
        self._defined.update(types)


def _types_from_idl(text: str) -> dict[str, Any]:
    """Return the types of one IDL file, or of several joined as bags do."""
    if not text.startswith(IDL_SEPARATOR + "IDL: "):
        return dict(get_types_from_idl(text))
    types: dict[str, Any] = {}
    for part in text.split(IDL_SEPARATOR)[1:]:
        types.update(get_types_from_idl(part.split("\n", 1)[1]))
    return types
