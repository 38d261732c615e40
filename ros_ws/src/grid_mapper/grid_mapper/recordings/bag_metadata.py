"""The part of metadata.yaml that the storage files of old bags do not hold: QoS profiles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from rosbags.interfaces import Qos
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import parse_qos

from grid_mapper.recordings.bag_files import METADATA_NAME


def metadata_qos(path: Path) -> dict[str, list[Qos]]:
    """Return the QoS profiles by topic; empty where there is no readable metadata.yaml."""
    file = (path if path.is_dir() else path.parent) / METADATA_NAME
    try:
        content: Any = yaml.safe_load(file.read_text(encoding="utf-8"))
        topics = content["rosbag2_bagfile_information"]["topics_with_message_count"]
        metadata = [topic["topic_metadata"] for topic in topics]
        return {m["name"]: parse_qos(m.get("offered_qos_profiles", "")) for m in metadata}
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ReaderError):
        return {}
