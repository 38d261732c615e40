"""Result folders, summaries, exit codes and the report page."""

import json
import signal
from pathlib import Path

import numpy as np
import pytest

from floornav_common.reporting import (
    Figures,
    Section,
    Table,
    UserError,
    open_out_dir,
    run_command,
    summary,
    write_html,
    write_summary,
)

_HEAD = ["command", "version", "seed", "machine", "python", "packages", "wall_s", "ok"]


@pytest.fixture(autouse=True)
def _keep_signals():
    before = {signum: signal.getsignal(signum) for signum in (signal.SIGINT, signal.SIGTERM)}
    yield
    for signum, handler in before.items():
        signal.signal(signum, handler)


def test_summary_begins_with_the_common_keys_and_has_null_for_nan(tmp_path: Path) -> None:
    values = {"command": "c", "seed": 3, "ok": True, "a": np.nan, "b": None, "c": np.float64(2.0)}
    read = json.loads(write_summary(tmp_path, values).read_text())
    assert list(read)[:8] == _HEAD
    assert (read["a"], read["b"], read["c"], read["seed"]) == (None, None, 2.0, 3)


def test_summary_of_a_stopped_block_is_marked_partial(tmp_path: Path) -> None:
    with (
        pytest.raises(KeyboardInterrupt),
        summary(tmp_path, command="c", seed=0, values={"scans": None}) as values,
    ):
        values["scans"] = 7
        raise KeyboardInterrupt
    read = json.loads((tmp_path / "summary.json").read_text())
    assert (read["ok"], read["partial"], read["scans"]) == (False, True, 7)


def test_no_temporary_file_stays_behind(tmp_path: Path) -> None:
    write_summary(tmp_path, {})
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]


def test_an_existing_folder_gets_a_number_and_is_named(tmp_path: Path, capsys) -> None:
    first = open_out_dir("demo", "x", tmp_path / "r")
    (first / "file").touch()
    second = open_out_dir("demo", "x", tmp_path / "r")
    assert second.name == "r-2"
    assert str(second) in capsys.readouterr().err


def test_an_empty_existing_folder_is_used(tmp_path: Path) -> None:
    assert open_out_dir("demo", "x", tmp_path) == tmp_path


@pytest.mark.parametrize(
    ("error", "code"), [(UserError("no such bag"), 2), (KeyboardInterrupt(), 1), (OSError(), 1)]
)
def test_exit_codes(error: BaseException, code: int) -> None:
    def main() -> int:
        raise error

    assert run_command(main) == code


def test_user_error_is_one_line_without_traceback(capsys) -> None:
    def main() -> int:
        raise UserError("no bag at x.mcap")

    run_command(main)
    assert capsys.readouterr().err == "error: no bag at x.mcap\n"


def test_page_escapes_text_and_needs_no_scripts(tmp_path: Path) -> None:
    sections = [Section("<b>", [Figures([("ATE", "1 cm")]), Table(["k"], [["<x>"], [1.0]])])]
    page = write_html(tmp_path, "title", sections).read_text()
    assert "&lt;x&gt;" in page and "<h2>&lt;b&gt;" in page
    assert "<script" not in page
