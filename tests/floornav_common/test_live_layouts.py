"""The files for RViz and Foxglove can be read and name topics that floornav's nodes have."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

CONFIG = Path("ros_ws/src/floornav_common/config")
SHOWN = {
    "/map", "/map/glass", "/scan", "/sonar", "/pose", "/trajectory", "/path", "/planner/markers",
    "/floor/overlay", "/goal_pose",
}  # fmt: skip
LATCHED = {"/map", "/map/glass", "/path"}


@pytest.fixture
def rviz(repository: Path) -> Any:
    return yaml.safe_load((repository / CONFIG / "floornav.rviz").read_text())


@pytest.fixture
def foxglove(repository: Path) -> Any:
    return json.loads((repository / CONFIG / "floornav.foxglove.json").read_text())


def rviz_topics(rviz: Any) -> dict[str, Any]:
    manager = rviz["Visualization Manager"]
    parts = [part for part in manager["Displays"] + manager["Tools"] if "Topic" in part]
    return {part["Topic"]["Value"]: part["Topic"] for part in parts}


def test_rviz_shows_and_sends_what_the_live_view_does(rviz: Any) -> None:
    assert set(rviz_topics(rviz)) >= SHOWN


def test_rviz_asks_for_what_nodes_offer(rviz: Any) -> None:
    """Latched topics are asked for as such; sensors as sensors, so that any driver matches."""
    for name, topic in rviz_topics(rviz).items():
        wanted = "Transient Local" if name in LATCHED else "Volatile"
        assert topic["Durability Policy"] == wanted, name
    for name in ("/scan", "/sonar", "/floor/overlay"):
        assert rviz_topics(rviz)[name]["Reliability Policy"] == "Best Effort"


def test_rviz_reads_no_yaml_merges(repository: Path) -> None:
    """yaml-cpp, which RViz reads with, does not know them."""
    assert "<<" not in (repository / CONFIG / "floornav.rviz").read_text()


def test_foxglove_shows_and_sends_what_the_live_view_does(foxglove: Any) -> None:
    panels = foxglove["configById"]
    topics = {t for t, v in panels["3D!floornav"]["topics"].items() if v["visible"]}
    topics |= {panels["Image!floor"]["imageMode"]["imageTopic"]}
    assert topics >= SHOWN
    assert panels["3D!floornav"]["publish"]["poseTopic"] == "/goal_pose"


def test_every_panel_of_the_layout_is_described_once(foxglove: Any) -> None:
    def leaves(part: Any) -> list[str]:
        return [part] if isinstance(part, str) else leaves(part["first"]) + leaves(part["second"])

    assert sorted(leaves(foxglove["layout"])) == sorted(foxglove["configById"])
