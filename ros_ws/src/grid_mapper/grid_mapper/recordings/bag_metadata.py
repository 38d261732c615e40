"""The parts of metadata.yaml that storage files do not hold: old bags' QoS, names of the files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from rosbags.interfaces import Qos
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import parse_qos

METADATA_NAME = "metadata.yaml"
UNREADABLE = (OSError, UnicodeDecodeError, yaml.YAMLError)


def metadata_files(path: Path) -> list[str]:
    """Return the storage files that metadata.yaml names; empty where it cannot be read."""
    try:
        names = _content(path)["relative_file_paths"]
        return [str(name) for name in names] if isinstance(names, list) else []
    except (*UNREADABLE, KeyError, TypeError):
        return []


def metadata_qos(path: Path) -> dict[str, list[Qos]]:
    """Return the QoS profiles by topic; empty where there is no readable metadata.yaml."""
    try:
        topics = _content(path)["topics_with_message_count"]
        metadata = [topic["topic_metadata"] for topic in topics]
        return {m["name"]: parse_qos(m.get("offered_qos_profiles", "")) for m in metadata}
    except (*UNREADABLE, KeyError, TypeError, AttributeError, ReaderError):
        return {}


def _content(path: Path) -> Any:
    file = (path if path.is_dir() else path.parent) / METADATA_NAME
    return yaml.safe_load(file.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
