"""evaluate.py all: what it runs, and that one that fails takes nothing along."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import evaluate
from experiments import whole_set, whole_set_process
from experiments.whole_set_list import LEFT_OUT, SET, Item


def test_every_experiment_is_in_the_set_or_left_out() -> None:
    assert {item.experiment for item in SET} == set(evaluate.EXPERIMENTS) - set(LEFT_OUT)
    names = [item.name for item in SET]
    assert len(set(names)) == len(names)


def test_every_command_of_the_set_is_understood_by_its_experiment() -> None:
    for item in SET:
        for is_full in (False, True):
            words = item.words(Path("data"), is_full=is_full)
            assert "{}" not in words
            args = evaluate._parsed(words)
            assert hasattr(args, "jobs") == (item.kind == "spread"), item.name


def test_recordings_are_filled_in_and_a_missing_one_is_named(tmp_path: Path) -> None:
    item = Item(experiment="x", quick="--a {} --b {}", recordings=("one", "two"))
    (tmp_path / "one").touch()
    given = [str(tmp_path / "one"), str(tmp_path / "two")]
    assert item.words(tmp_path, is_full=False) == ["x", "--a", given[0], "--b", given[1]]
    assert item.missing(tmp_path) == tmp_path / "two"
    (tmp_path / "two").touch()
    assert item.missing(tmp_path) is None


def test_one_that_fails_and_one_without_recording_are_named_and_the_rest_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    gray = np.random.default_rng(0).integers(0, 255, (48, 96), np.uint8)
    for name, shift in (("left.png", 0), ("right.png", 4)):
        cv2.imwrite(str(tmp_path / name), np.roll(gray, -shift, axis=1))
    cv2.imwrite(str(tmp_path / "truth.png"), np.full_like(gray, 4 * 16))
    pair = "--pair {} {} --gt {} --scale 16 --disparities 16"
    names = ("left.png", "right.png", "truth.png")
    items = (
        Item(experiment="stereo-matching", part="bad", quick="--pair nope nope"),
        Item(experiment="stereo-matching", part="none", quick=pair, recordings=("left.png", "x")),
        Item(experiment="stereo-matching", part="good", quick=pair, recordings=names),
    )
    monkeypatch.setattr(whole_set, "SET", items)
    out = tmp_path / "out"
    code = evaluate.main(["all", "--data", str(tmp_path), "--out", str(out)])
    assert code == 1
    assert "failed: stereo-matching-bad" in capfd.readouterr().err
    summary = json.loads((out / "summary.json").read_text())
    states = {row["name"]: row["state"] for row in summary["experiments"]}
    good, bad, none = (f"stereo-matching-{part}" for part in ("good", "bad", "none"))
    assert states == {bad: "failed", none: "not run", good: "done"}
    assert summary["ok"] is False and summary[bad] is None and summary[none] is None
    assert summary[good]["experiment"] == "stereo-matching" and summary[good]["ok"] is True
    rows = {row["name"]: row for row in summary["experiments"]}
    assert rows[good]["cpu_s"] > 0.0 and str(tmp_path / "x") in rows[none]["reason"]
    page = (out / "report.html").read_text()
    assert page.count("<table>") >= 2 and "no recording" in page and f"{good}: " in page
    assert (out / good / "report.html").exists() and (out / good / "log.txt").exists()


def test_one_that_dies_is_told_with_its_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "dying_one.py").write_text("import os\n\n\ndef die(*_):\n    os._exit(9)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    import dying_one

    monkeypatch.setattr(whole_set_process, "_experiment", dying_one.die)
    outcome = whole_set_process.run_item("some", ["some"], tmp_path / "some")
    assert outcome.state == "failed" and "exit code 9" in outcome.reason
