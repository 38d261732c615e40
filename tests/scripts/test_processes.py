"""The children of a script end with it, whatever happens to it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

import _processes
from _processes import ChildDiedError, Processes

STARTER = """
import os, sys, time
sys.path.insert(0, {scripts!r})
from pathlib import Path
from _processes import Processes

with Processes(Path({logs!r}), os.environ) as children:
    children.start("child", [sys.executable, "-c", "import os, time; print(os.getpid(), flush=True); time.sleep(600)"])
    children.wait_for_line("child", "\\n", 60.0, lambda: time.sleep(0.01))
    print(children.tail("child"), flush=True)
    time.sleep(600)
"""  # noqa: E501


def is_running(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells children of their starter")
def test_a_starter_that_is_killed_outright_leaves_no_child_behind(tmp_path: Path) -> None:
    scripts = str(Path(_processes.__file__).parent)
    code = STARTER.format(scripts=scripts, logs=str(tmp_path))
    starter = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert starter.stdout is not None
    pid = int(starter.stdout.readline())
    assert is_running(pid)
    starter.kill()
    starter.communicate(timeout=60)
    end = time.monotonic() + 60.0
    while is_running(pid):
        assert time.monotonic() < end, f"child {pid} still runs"
        time.sleep(0.05)


def test_a_child_that_ends_is_named_with_its_exit_code_and_last_lines(tmp_path: Path) -> None:
    with Processes(tmp_path, {}) as children:
        children.start("bad", [sys.executable, "-c", "print('so it goes'); raise SystemExit(3)"])
        while children.exit_code("bad") is None:
            time.sleep(0.01)
        with pytest.raises(ChildDiedError, match="bad ended with exit code 3.*\\n.*so it goes"):
            children.check()


def test_leaving_the_block_ends_the_children(tmp_path: Path) -> None:
    with Processes(tmp_path, {}) as children:
        children.start("long", [sys.executable, "-c", "import time; time.sleep(600)"])
    assert children.exit_code("long") is not None
