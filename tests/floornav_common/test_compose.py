"""Finding nodes by PACKAGE/EXECUTABLE."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from typing import Any

import pytest

from floornav_common import compose


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    scripts = [
        EntryPoint("grid_mapper", "grid_mapper.nodes.grid_mapper_node:main", "console_scripts"),
        EntryPoint("map_bag", "grid_mapper.map_bag:main", "console_scripts"),
        EntryPoint("other", "elsewhere.cli:main", "console_scripts"),
    ]
    monkeypatch.setattr(compose, "entry_points", lambda **_: scripts)


def test_only_nodes_are_found(installed: Any) -> None:
    assert list(compose.nodes_installed()) == ["grid_mapper/grid_mapper"]


def test_an_unknown_node_is_exit_code_2_and_names_what_there_is(
    installed: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compose.main(["grid_mapper/map_bag"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].endswith("there are: grid_mapper/grid_mapper")


def test_no_node_at_all_is_a_usage_error(installed: Any) -> None:
    with pytest.raises(SystemExit) as caught:
        compose.main(["--ros-args", "-p", "x:=1"])
    assert caught.value.code == 2


def test_the_class_is_the_one_node_its_module_defines(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rclpy")
    monkeypatch.syspath_prepend(str(__import__("pathlib").Path(__file__).parents[1] / "graph"))
    entry = EntryPoint("common", "common_nodes:main", "console_scripts")
    monkeypatch.setattr(compose, "nodes_installed", lambda: {"a/common": entry})
    with pytest.raises(ValueError, match="must define one node class, it defines"):
        compose.find_node_class("a/common")
