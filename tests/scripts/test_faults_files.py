"""Settings drawn at random, files that are none, and starts that must be refused."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes are what is drawn for")
from experiments.faults_files import Attempt, try_starts, write_maps, write_worlds  # noqa: E402
from experiments.faults_fuzz import NODES, as_words, draw_set, try_set  # noqa: E402
from grid_mapper.map_files import load_map  # noqa: E402
from sim_bridge.robot_model import load_robot  # noqa: E402
from sim_bridge.schema import WorldError  # noqa: E402
from sim_bridge.world import load_world  # noqa: E402

PLANNER = "sjmc_planner local_planner"


@pytest.mark.parametrize("node", sorted(NODES))
def test_settings_drawn_at_random_are_taken_or_refused_by_name(node: str) -> None:
    rng = np.random.default_rng(0)
    found = [try_set(node, draw_set(rng, node)) for _ in range(60)]
    assert [problem for _, problem in found if problem] == []
    assert {is_taken for is_taken, _ in found} == {True, False}


def test_what_is_no_clear_refusal_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    import experiments.faults_fuzz as fuzz

    def fail(*_: object) -> None:
        raise TypeError("no")

    assert try_set(PLANNER, {"lookahead_m": -1.0}) == (False, "")
    monkeypatch.setattr(fuzz, "config_from_mapping", fail)
    assert "TypeError" in try_set(PLANNER, {"lookahead_m": -1.0})[1]


def test_values_are_written_as_a_command_line_takes_them() -> None:
    values = {"a": float("nan"), "b": True, "c": (1, 2.5), "d": "x", "e": "\x00", "f": -1e300}
    assert as_words(values) == [
        "-p", "a:=.nan", "-p", "b:=true", "-p", "c:=[1, 2.5]", "-p", "d:='x'", "-p", "f:=-1e+300",
    ]  # fmt: skip


def test_no_malformed_world_or_map_is_taken(tmp_path: Path) -> None:
    for path in write_worlds(tmp_path / "worlds").values():
        with pytest.raises(WorldError):
            load_robot(load_world(str(path)).robots[0])
    for path in write_maps(tmp_path / "maps").values():
        with pytest.raises(Exception, match=r"."):
            load_map(path)


def test_a_refusal_is_exit_code_2_and_no_traceback() -> None:
    assert Attempt("a", 2, "start_map x: bad\n").problem == ""
    assert "runs" in Attempt("a", None, "[x]: ready").problem
    assert "ended with 1" in Attempt("a", 1, "bad").problem
    assert "ValueError: no" in Attempt("a", 2, "Traceback ...\nValueError: no").problem


def test_starts_are_followed_to_their_end_or_until_they_run(tmp_path: Path) -> None:
    def program(text: str) -> list[str]:
        return [sys.executable, "-c", text]

    commands = {
        "refused": program("import sys; sys.exit('bad' and 2)"),
        "runs": program("import time; print('[n]: ready', flush=True); time.sleep(600)"),
        "dies": program("raise ValueError('no')"),
    }
    found = {a.name: a for a in try_starts(commands, tmp_path, lambda: None)}
    assert [found[name].code for name in ("refused", "runs", "dies")] == [2, None, 1]
    assert "ValueError: no" in found["dies"].text
