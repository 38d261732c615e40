"""Make the project's environment, or find that it is up to date.

An environment is four layers: the virtual environment, the pinned libraries, tf2_msgs (pip home
only) and links to our packages. `floornav-environment.json` in it says which version of each is
there. It is written after each layer, so an interrupted set-up continues or starts again and is
never taken for a good one. A changed lock makes the environment anew; changed interface definitions
or package files renew their layer only.

Standard library only, and syntax that Python 3.9 reads.
"""

import fcntl
import os
import shutil
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from _environment import ROOT, clean_child_environment
from _environment_stamp import digest, read_stamp, write_stamp
from _environment_steps import say, step
from _package_links import link_packages, linked_checkout, links_key
from _pip_progress import pip_install
from _python_choice import choose_python, probe
from _tf2_msgs import SOURCE_DIR, BuildToolMissingError, build_tf2_msgs, check_compiler, find_cmake

PIP_LOCK = ROOT / "requirements" / "pip-home.txt"
CMAKE_LOCK = ROOT / "requirements" / "pip-cmake.txt"
ROBOT_LOCK = ROOT / "requirements-robot.txt"
RECIPE = "1"  # raise it when the libraries must be installed anew although the lock is the same
NEEDED_GB = {False: 2.5, True: 1.0}


class SetupError(Exception):
    """The environment cannot be made; the text is for the user."""


class Home(NamedTuple):
    """Where the environment is, and whether it builds on the system's ROS."""

    prefix: Path
    is_system: bool


def ready_home(is_system=False):
    """Return the environment, made or renewed if it has to be.

    Args:
        is_system: Use the installed ROS 2 Jazzy instead of the wheels.

    Raises:
        SetupError: If it cannot be made.
    """
    home = Home(home_prefix(is_system), is_system)
    if is_current(home):
        return home
    try:
        with _only_one(home.prefix):
            if not is_current(home):  # another command may have made it meanwhile
                _make(home)
    except OSError as error:
        raise SetupError(f"cannot make {home.prefix}: {error}") from error
    return home


def home_prefix(is_system):
    """Return the folder of the environment."""
    if is_system:
        return ROOT / ".venv-ros"
    return Path(os.environ.get("FLOORNAV_VENV") or ROOT / ".venv").absolute()


def is_current(home):
    """Tell whether every layer is there and up to date. Reads a few files and runs nothing."""
    stamp = read_stamp(home.prefix)
    return (
        (home.prefix / "bin" / "python").exists()
        and not _is_other_python_asked(stamp)
        and stamp.get("libraries") == libraries_key(home)
        and stamp.get("tf2_msgs") == tf2_key(home, stamp)
        and stamp.get("packages") == links_key()
    )


def libraries_key(home):
    """Hash what decides the libraries: lock, recipe, and the folder (scripts in bin name it)."""
    lock = ROBOT_LOCK if home.is_system else PIP_LOCK
    return digest(lock.read_bytes(), RECIPE.encode(), str(home.prefix).encode())


def tf2_key(home, stamp):
    """Hash the interface definitions and their builder; keep "missing" while tools are missing."""
    if home.is_system:
        return None
    if stamp.get("tf2_msgs") == "missing":
        try:
            check_compiler()
        except BuildToolMissingError:
            return "missing"
    files = [path for path in sorted(SOURCE_DIR.rglob("*")) if path.is_file()]
    builder = Path(__file__).with_name("_tf2_msgs.py")
    return digest(*[path.read_bytes() for path in [*files, builder]])


def _is_other_python_asked(stamp):
    """Tell whether FLOORNAV_PYTHON names another Python than the environment has."""
    asked = os.environ.get("FLOORNAV_PYTHON")
    if not asked or stamp.get("asked_python") == asked:
        return False
    found = probe(shutil.which(asked) or asked)
    return found is None or found.version_text != stamp.get("python")


def _make(home):
    """Make what is missing, layer by layer, and stamp each."""
    start = time.monotonic()
    stamp = read_stamp(home.prefix)
    is_new = stamp.get("libraries") != libraries_key(home) or _is_other_python_asked(stamp)
    if is_new or not (home.prefix / "bin" / "python").exists():
        stamp = _make_libraries(home)
    if stamp.get("tf2_msgs") != tf2_key(home, stamp):
        _make_tf2_msgs(home, stamp)
    if stamp.get("packages") != links_key():
        _warn_of_other_checkout(home)
        link_packages(home.prefix)
        stamp["packages"], stamp["checkout"] = links_key(), str(ROOT)
        write_stamp(home.prefix, stamp)
    if is_new:
        say(f"environment ready after {time.monotonic() - start:.0f} s")


def _warn_of_other_checkout(home):
    other = linked_checkout(home.prefix)
    if other is not None:
        say(
            f"WARNING: the environment {home.prefix} belonged to {other}; from now on what runs in "
            f"it is the code of {ROOT}, also what was started from there. FLOORNAV_VENV must name "
            "another folder for each checkout"
        )


def _make_libraries(home):
    """Make the virtual environment and install the pinned libraries; return the new stamp."""
    lock = ROBOT_LOCK if home.is_system else PIP_LOCK
    python = _base_python(home)
    _check_space(home)
    old = (
        "again (its pins or its Python changed, or it was not finished)"
        if home.prefix.exists()
        else "on first use"
    )
    say(
        f"making the environment {home.prefix} {old}, Python {python.version_text}; "
        "this takes 1 to 5 minutes"
    )
    if home.prefix.exists():
        shutil.rmtree(home.prefix)
    with step("virtual environment"):
        options = ["--system-site-packages"] if home.is_system else []
        _run([python.path, "-m", "venv", *options, str(home.prefix)])
    if not home.is_system and python.version >= (3, 12):
        say("  note: sim_bridge needs pybullet, no wheel for Python 3.12 (requirements/README.md)")
    with step("libraries") as report:
        pip_install(home.prefix, lock, report, SetupError)
    stamp = {"python": python.version_text, "asked_python": os.environ.get("FLOORNAV_PYTHON")}
    stamp["libraries"] = libraries_key(home)
    write_stamp(home.prefix, stamp)
    return stamp


def _base_python(home):
    """Return the Python that the environment is made with."""
    if home.is_system:  # rclpy is compiled for the system's own
        found = probe("/usr/bin/python3")
        if found is None or not found.has_venv:
            raise SetupError(
                "/usr/bin/python3 cannot make virtual environments: install python3-venv"
            )
        return found
    try:
        return choose_python()
    except LookupError as error:
        raise SetupError(error.args[0]) from None


def _make_tf2_msgs(home, stamp):
    """Build tf2_msgs, or say in one line why not."""
    try:
        check_compiler()
        with step("tf2_msgs, compiled from its definitions") as report:
            if find_cmake(home.prefix) is None:
                pip_install(home.prefix, CMAKE_LOCK, report, SetupError)
            build_tf2_msgs(home.prefix)
        stamp["tf2_msgs"] = tf2_key(home, {})
    except BuildToolMissingError as error:
        say(f"tf2_msgs not built, {error}: everything but TF runs; install it and run this again")
        stamp["tf2_msgs"] = "missing"
    except RuntimeError as error:
        raise SetupError(str(error)) from error
    write_stamp(home.prefix, stamp)


def _check_space(home):
    """Raise SetupError if the disk is too full."""
    free_gb = shutil.disk_usage(home.prefix.parent).free / 1e9
    if free_gb < NEEDED_GB[home.is_system]:
        raise SetupError(
            f"{home.prefix} needs {NEEDED_GB[home.is_system]} GB, {free_gb:.1f} GB are left there"
        )


def _run(command):
    """Run a command quietly; its output is shown only if it fails."""
    answer = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=clean_child_environment()
    )
    if answer.returncode != 0:
        raise SetupError(
            f"{' '.join(command)} failed:\n{answer.stdout.decode(errors='replace').strip()}"
        )


@contextmanager
def _only_one(prefix):
    """Hold the lock of the environment, waiting for another command that is making it."""
    prefix.parent.mkdir(parents=True, exist_ok=True)
    with open(prefix.parent / f"{prefix.name}.lock", "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("another command is making the environment; waiting for it")
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
