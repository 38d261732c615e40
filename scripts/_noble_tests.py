#!/usr/bin/env python3
"""Run the tests of the cores on Ubuntu 24.04's library versions: Python 3.12, numpy 1.26, no ROS.

Makes `.venv-noble` from `requirements/noble.txt` on first use. Without a Python 3.12 it says so,
loudly, and exits with 0: a machine without one can still check the rest.
"""

import os
import shutil
import subprocess
import sys

from _environment import ROOT, clean_child_environment
from _environment_build import SetupError
from _environment_stamp import digest, read_stamp, write_stamp
from _environment_steps import step
from _package_links import link_packages
from _pip_progress import pip_install
from _python_choice import candidates, probe

LOCK = ROOT / "requirements" / "noble.txt"
PREFIX = ROOT / ".venv-noble"
TESTS = ROOT / "tests"


def main() -> int:
    """Make the environment if it has to be, then run pytest in it."""
    python = _python_3_12()
    if python is None:
        print(
            "*** NOT RUN: no Python 3.12 on this machine, so noble's library versions are untested"
        )
        return 0
    key = digest(LOCK.read_bytes(), str(PREFIX).encode(), python.version_text.encode())
    if read_stamp(PREFIX).get("libraries") != key:
        try:
            _make(python.path)
        except SetupError as error:
            print(f"error: {error}", file=sys.stderr)
            return 1
        write_stamp(PREFIX, {"libraries": key})
    link_packages(PREFIX)
    environ = clean_child_environment()
    for name in ("PYTHONPATH", "AMENT_PREFIX_PATH", "ROS_DISTRO"):
        environ.pop(name, None)
    environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    environ["NUMBA_CACHE_DIR"] = str(PREFIX / "cache" / "numba")
    environ["MPLCONFIGDIR"] = str(PREFIX / "cache" / "matplotlib")
    ignored = [f"--ignore=tests/{p.name}" for p in sorted(TESTS.iterdir()) if not _is_core(p)]
    spread = ["--numprocesses", "auto", "--maxprocesses", "4", "--dist", "loadfile"]
    command = [str(PREFIX / "bin" / "python"), "-m", "pytest", "tests", *spread, *ignored]
    command += sys.argv[1:]
    return subprocess.run(command, cwd=ROOT, env=environ).returncode


def _is_core(path):
    """Tell whether tests need neither ROS nor the scripts: those named after a package."""
    return path.name == "conftest.py" or (ROOT / "ros_ws" / "src" / path.name).is_dir()


def _python_3_12():
    """Return a Python 3.12 that can make virtual environments, or None."""
    for path in candidates(os.environ):
        found = probe(path)
        if found and found.version == (3, 12) and found.has_venv:
            return found
    return None


def _make(python):
    """Make the environment of the second set."""
    shutil.rmtree(PREFIX, ignore_errors=True)
    with step("virtual environment for noble's versions"):
        subprocess.run(
            [python, "-m", "venv", str(PREFIX)], check=True, env=clean_child_environment()
        )
    with step("noble's versions") as report:
        pip_install(PREFIX, LOCK, report, SetupError)


if __name__ == "__main__":
    sys.exit(main())
