"""Finding nodes by PACKAGE/EXECUTABLE."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from floornav_common import compose


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    scripts = [
        EntryPoint("grid_mapper", "grid_mapper.nodes.start:grid_mapper", "console_scripts"),
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


def test_the_class_is_the_one_node_its_module_defines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rclpy")
    folder = tmp_path / "two" / "nodes"
    folder.mkdir(parents=True)
    node = "from rclpy.node import Node\n\n\nclass {}(Node):\n    pass\n"
    (folder / "pair_node.py").write_text(node.format("Left") + node.format("Right"))
    (folder / "one_node.py").write_text(node.format("One"))
    monkeypatch.syspath_prepend(str(tmp_path))
    entry = EntryPoint("pair", "two.nodes.start:pair", "console_scripts")
    monkeypatch.setattr(compose, "nodes_installed", lambda: {"two/pair": entry, "two/one": entry})
    assert compose.find_node_class("two/one").__name__ == "One"
    with pytest.raises(ValueError, match="must define one node class, it defines 2"):
        compose.find_node_class("two/pair")
