"""Write a rosbag2 that appears when it is complete, and not at all if it fails."""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
METADATA_VERSION = 9
"""What Jazzy writes."""
COMMIT_BYTES = 4 * 2**20
"""A database keeps what it has committed when the disk fills up or the machine dies."""
WRITE_ERRORS = (OSError, sqlite3.Error)
"""What writing raises on a full disk."""
UNKNOWN_HASH = "RIHS01_" + 64 * "0"


class BagWriter:
    """Writes serialized messages to a new rosbag2; close it, or abort it.

    The bag grows in a hidden folder beside its place and is moved there when it is closed.

    Args:
        path: Folder of the bag; must not exist.
        storage: `mcap` or `sqlite3`.

    Raises:
        FileExistsError: If the folder exists.
        ValueError: If the storage is neither.
    """

    def __init__(self, path: Path, storage: str = "mcap") -> None:
        """Make the hidden folder."""
        if storage not in STORAGES:
            raise ValueError(f"storage must be one of {', '.join(STORAGES)}, got {storage!r}")
        if path.exists():
            raise FileExistsError(f"{path} exists")
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        self.num_messages = 0
        self._folder = Path(tempfile.mkdtemp(dir=path.parent, prefix=f".{path.name}."))
        self._writer = Writer(
            self._folder / path.name, version=METADATA_VERSION, storage_plugin=STORAGES[storage]
        )
        self._writer.open()
        self._connections: dict[str, Connection] = {}
        self._num_uncommitted_bytes = 0
        self._store = get_typestore(Stores.ROS2_JAZZY)

    def add_topic(
        self,
        name: str,
        msgtype: str,
        qos: Sequence[Qos] = (),
        definition: str = "",
        type_hash: str = UNKNOWN_HASH,
    ) -> None:
        """Announce a topic.

        Args:
            name: Full name.
            msgtype: Such as `sensor_msgs/msg/LaserScan`.
            qos: What its publishers offer.
            definition: Text of the definition, for types that Jazzy does not bring.
            type_hash: Of the type, as DDS carries it.
        """
        if definition or msgtype not in self._store.fielddefs:
            connection = self._writer.add_connection(
                name, msgtype, msgdef=definition, rihs01=type_hash, offered_qos_profiles=qos
            )
        else:
            connection = self._writer.add_connection(
                name, msgtype, typestore=self._store, offered_qos_profiles=qos
            )
        self._connections[name] = connection

    def write(self, topic: str, recorded_ns: int, data: bytes) -> None:
        """Add one serialized message.

        Raises:
            KeyError: If the topic was not announced.
            OSError: If there is no room for it; or another of `WRITE_ERRORS`.
        """
        self._writer.write(self._connections[topic], recorded_ns, data)
        self.num_messages += 1
        self._num_uncommitted_bytes += len(data)
        if self._num_uncommitted_bytes > COMMIT_BYTES:
            self._commit()

    def close(self) -> None:
        """Complete the bag and move it to its place.

        Raises:
            OSError: If there is no room to complete it; or another of `WRITE_ERRORS`. What is on
                the disk by then is kept.
        """
        try:
            self._writer.close()
        except WRITE_ERRORS:
            self.keep()
            raise
        self._move()

    def keep(self) -> None:
        """Move what is on the disk to its place as it is: a bag that is cut off, but readable."""
        with contextlib.suppress(*WRITE_ERRORS):
            self._commit()
        with contextlib.suppress(*WRITE_ERRORS):
            self._writer.abort()
        self._move()

    def _commit(self) -> None:
        connection = getattr(self._writer.storage, "conn", None)
        if connection is not None:
            connection.commit()
        self._num_uncommitted_bytes = 0

    def _move(self) -> None:
        try:
            (self._folder / self.path.name).rename(self.path)
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def abort(self) -> None:
        """Leave nothing behind."""
        self._writer.abort()
        shutil.rmtree(self._folder, ignore_errors=True)
