"""Signals that come while a node is still being imported."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

CODE = "import sys; from floornav_common.start import start_node; sys.exit(start_node('{}'))"


def run(folder: Path, module: str, body: str) -> subprocess.Popen[str]:
    (folder / f"{module}.py").write_text(body)
    return subprocess.Popen(
        [sys.executable, "-c", CODE.format(module)],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_the_imports_ends_the_process_with_0_and_no_word(
    tmp_path: Path, sign: signal.Signals
) -> None:
    body = "import time\nprint('importing', flush=True)\ntime.sleep(600)\n"
    process = run(tmp_path, "slow_node", body)
    assert process.stdout is not None
    assert process.stdout.readline() == "importing\n"
    process.send_signal(sign)
    said, _ = process.communicate(timeout=60)
    assert (process.returncode, said) == (0, "")


def test_the_exit_code_is_that_of_the_nodes_main(tmp_path: Path) -> None:
    process = run(tmp_path, "failing_node", "def main():\n    return 2\n")
    assert process.communicate(timeout=60)[0] == ""
    assert process.returncode == 2
