#!/usr/bin/env python3
"""Make the locks again from the .in files: `python3 requirements/lock.py`.

Each lock pins every package, names the hashes of all its files, and holds for every platform
(markers decide), so that one file serves Python 3.11 and 3.12. `uv` does the resolving; it is taken
from PATH or installed into a scratch environment. Indexes other than PyPI's are not asked.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
LOCKS = (
    # source, lock, oldest Python it must hold for
    ("pip-home.in", HERE / "pip-home.txt", "3.11"),
    ("pip-cmake.in", HERE / "pip-cmake.txt", "3.11"),
    ("colcon.in", HERE / "colcon.txt", "3.11"),
    ("noble.in", HERE / "noble.txt", "3.12"),
    ("robot.in", HERE.parent / "requirements-robot.txt", "3.12"),
)


def main() -> int:
    """Resolve each .in file; keep what a lock already pins unless --upgrade is given."""
    options = ["--upgrade"] if "--upgrade" in sys.argv[1:] else []
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("UV_", "PIP_"))}
    with tempfile.TemporaryDirectory() as scratch:
        uv = shutil.which("uv") or _install_uv(Path(scratch))
        for source, lock, python in LOCKS:
            command = [uv, "pip", "compile", "--universal", "--generate-hashes", "--no-config"]
            command += ["--no-annotate", "--no-header", "--quiet", "--python-version", python]
            command += [*options, str(HERE / source), "-o", str(lock)]
            if subprocess.run(command, stdout=subprocess.DEVNULL, env=environment).returncode != 0:
                print(f"error: could not lock {source}", file=sys.stderr)
                return 1
            print(f"{lock.relative_to(HERE.parent)} made from requirements/{source}")
    return 0


def _install_uv(scratch: Path) -> str:
    """Install uv into a scratch environment and return its path."""
    venv.create(scratch / "venv", with_pip=True)
    python = scratch / "venv" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", "uv"], check=True)
    return str(scratch / "venv" / "bin" / "uv")


if __name__ == "__main__":
    sys.exit(main())
