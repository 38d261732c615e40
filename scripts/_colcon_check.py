#!/usr/bin/env python3
"""Build the workspace with colcon, as on a robot, and look for what `ros2 run` needs.

Makes `.venv-colcon` from `requirements/colcon.txt` on first use; builds in a scratch folder.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from _environment import ROOT, clean_child_environment
from _environment_build import SetupError
from _environment_stamp import digest, read_stamp, write_stamp
from _environment_steps import step
from _package_links import find_packages
from _pip_progress import pip_install
from _python_choice import choose_python

LOCK = ROOT / "requirements" / "colcon.txt"
PREFIX = ROOT / ".venv-colcon"


def main() -> int:
    """Build, then say what is missing in the install space."""
    try:
        _ready_environment()
    except (LookupError, SetupError) as error:
        print(f"error: {error.args[0]}", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory(prefix="floornav_colcon_") as scratch:
        if not _built(Path(scratch)):
            print("colcon build failed")
            return 1
        install = Path(scratch) / "install"
        missing = [str(p) for p in wanted_files() if not any(install.glob(str(p)))]
    packages = find_packages().values()
    if missing:
        print("missing after colcon build: " + ", ".join(missing))
        return 1
    num_executables = sum(len(p.executables) for p in packages)
    print(f"colcon built {len(packages)} packages with {num_executables} executables")
    return 0


def wanted_files() -> list[Path]:
    """Return patterns of what an install space must hold: for `ros2 run`, and all data files."""
    wanted = []
    for package in find_packages().values():
        prefix = Path(package.name)
        wanted.append(prefix / "share/ament_index/resource_index/packages" / package.name)
        wanted.append(prefix / "share" / package.name / "package.xml")
        wanted += [prefix / "lib" / package.name / name for name in package.executables]
        config = package.folder / "config"
        wanted += [prefix / "share" / package.name / "config" / p.name for p in config.glob("*")]
        inside = [p for p in (package.folder / package.name).rglob("*.*") if p.is_file()]
        inside = [p.relative_to(package.folder) for p in inside if "__pycache__" not in p.parts]
        wanted += [prefix / "lib" / "python3*" / "site-packages" / p for p in inside]
    return wanted


def _ready_environment() -> None:
    """Make the environment of colcon if it has to be."""
    python = choose_python()
    key = digest(LOCK.read_bytes(), str(PREFIX).encode(), python.version_text.encode())
    if read_stamp(PREFIX).get("libraries") == key:
        return
    shutil.rmtree(PREFIX, ignore_errors=True)
    with step("colcon") as report:
        command = [python.path, "-m", "venv", str(PREFIX)]
        subprocess.run(command, check=True, env=clean_child_environment())
        pip_install(PREFIX, LOCK, report, SetupError)
    write_stamp(PREFIX, {"libraries": key})


def _built(scratch: Path) -> bool:
    """Run colcon build; its output is shown only if it fails."""
    environ = clean_child_environment()
    for name in ("PYTHONPATH", "AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH"):
        environ.pop(name, None)
    environ["COLCON_HOME"] = str(scratch / "colcon")
    shutil.copytree(ROOT / "ros_ws" / "src", scratch / "src")  # builds leave egg-info behind
    python = str(PREFIX / "bin" / "python")
    command = [python, "-m", "colcon", "--log-base", "log", "build", "--base-paths", "src"]
    command += ["--event-handlers", "console_direct-", "console_cohesion+"]
    answer = subprocess.run(command, cwd=scratch, env=environ, capture_output=True, text=True)
    if answer.returncode != 0:
        print(answer.stdout[-6000:], answer.stderr[-6000:])
    return answer.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
