"""scripts/evaluate.py as a user starts it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS: an experiment talks over DDS")

EVALUATE = Path(__file__).resolve().parents[2] / "scripts" / "evaluate.py"


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--bag", "nope"], "no such recording: nope"),
        (["--bag", "empty"], "empty"),
        (["--bag", "empty", "a/empty"], "same name"),
    ],
)
def test_bad_input_of_live_mapping_is_one_line_and_leaves_no_folder(
    tmp_path: Path, words: list[str], expected: str
) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "a" / "empty").mkdir(parents=True)
    done = subprocess.run(
        [sys.executable, str(EVALUATE), "live-mapping", *words], cwd=tmp_path, timeout=300.0,
        env={**os.environ, "FLOORNAV_ENV_READY": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    text = done.stdout + done.stderr
    assert done.returncode == 2, text
    assert text.count("\n") == 1 and expected in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "empty"]


def test_the_terminal_names_and_explains_every_table() -> None:
    import evaluate
    from floornav_common.reporting import Section, Table

    text = evaluate._section_text(Section("Mirror", ["Radii, px.", Table(["a"], [["1"]])]))
    assert text.split() == ["Mirror", "Radii,", "px.", "a", "1"]


def test_an_option_of_another_experiment_is_refused_with_this_ones_usage(tmp_path: Path) -> None:
    words = [sys.executable, str(EVALUATE), "landmark-localization", "--layouts", "2"]
    done = subprocess.run(
        words, cwd=tmp_path, timeout=300.0, env={**os.environ, "FLOORNAV_ENV_READY": "1"},
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2, done.stdout + done.stderr
    assert "--headings" in done.stderr and "unrecognized arguments: --layouts 2" in done.stderr
