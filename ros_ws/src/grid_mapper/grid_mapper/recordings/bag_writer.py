"""Write a rosbag2 that appears when it is complete, and not at all if it fails."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
METADATA_VERSION = 9
"""What Jazzy writes."""
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
        """
        self._writer.write(self._connections[topic], recorded_ns, data)
        self.num_messages += 1

    def close(self) -> None:
        """Complete the bag and move it to its place."""
        try:
            self._writer.close()
            (self._folder / self.path.name).rename(self.path)
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def abort(self) -> None:
        """Leave nothing behind."""
        self._writer.abort()
        shutil.rmtree(self._folder, ignore_errors=True)
