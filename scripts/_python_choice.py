"""Find the Python that the project's environment is made with: 3.11, then 3.12.

A name on PATH may be a shim that fails, so each candidate is run to see what it is.
Standard library only; syntax that Python 3.9 reads.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

SUPPORTED = ((3, 11), (3, 12))
PROBE = """
import importlib.util as u, os, platform, sys, sysconfig
print(*sys.version_info[:2], platform.python_version(), platform.python_implementation())
print(getattr(sys, "_base_executable", None) or sys.executable)
print(int(u.find_spec("venv") is not None and u.find_spec("ensurepip") is not None))
print(int(os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h"))))
"""


class Interpreter(NamedTuple):
    """A python that runs."""

    path: str
    version: tuple
    version_text: str
    has_venv: bool
    has_headers: bool


def choose_python(environ=None):
    """Return the interpreter to use, or raise LookupError with one line that says what to do.

    FLOORNAV_PYTHON decides if it is set. Otherwise the first of 3.11, then of 3.12, that can make
    virtual environments; one with C headers is preferred, because tf2_msgs is compiled with them.
    """
    environ = os.environ if environ is None else environ
    asked = environ.get("FLOORNAV_PYTHON")
    if asked:
        return _asked_for(asked, environ)
    found = []
    for path in candidates(environ):
        found.append(probe(path, environ))
        if (
            found[-1]
            and found[-1].version == SUPPORTED[0]
            and found[-1].has_venv
            and found[-1].has_headers
        ):
            return found[-1]
    usable = [p for p in found if p and p.version in SUPPORTED and p.has_venv]
    if usable:
        return min(usable, key=lambda p: (p.version, not p.has_headers))
    without_venv = [p for p in found if p and p.version in SUPPORTED]
    if without_venv:
        raise LookupError(_no_venv(without_venv[0]))
    seen = ", ".join(sorted({p.version_text for p in found if p})) or "none"
    raise LookupError(
        f"Python 3.11 or 3.12 is needed (found: {seen}); install one or name it in FLOORNAV_PYTHON"
    )


def candidates(environ):
    """Yield paths that may be a supported Python, most natural first; none is run here."""
    seen = set()
    for path in _places(environ):
        if path and path not in seen and os.access(path, os.X_OK):
            seen.add(path)
            yield path


def probe(path, environ=None):
    """Run an interpreter and return what it is, or None if it does not work."""
    environ = {k: v for k, v in (environ or os.environ).items() if not k.startswith("PYTHON")}
    environ.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None)
    try:
        answer = subprocess.run(
            [path, "-c", PROBE],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=30,
            env=environ,
        )
        first, executable, has_venv, has_headers = answer.stdout.decode().splitlines()
        major, minor, text, implementation = first.split()
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None
    if answer.returncode != 0 or implementation != "CPython":
        return None
    return Interpreter(
        executable, (int(major), int(minor)), text, has_venv == "1", has_headers == "1"
    )


def _asked_for(asked, environ):
    """Return the interpreter that FLOORNAV_PYTHON names, if it is one we support."""
    found = probe(shutil.which(asked, path=environ.get("PATH")) or asked, environ)
    if found is None:
        raise LookupError(f"FLOORNAV_PYTHON={asked} does not run")
    if found.version not in SUPPORTED:
        raise LookupError(f"FLOORNAV_PYTHON={asked} is {found.version_text}, not 3.11 or 3.12")
    if not found.has_venv:
        raise LookupError(_no_venv(found))
    return found


def _no_venv(python):
    """Say what a Python without venv lacks."""
    package = "python{}.{}-venv".format(*python.version)
    return f"{python.path} cannot make virtual environments: install {package}"


def _places(environ):
    """Yield where a Python may be: ours, each on PATH, usual folders, pyenv's and uv's stores."""
    yield sys.executable
    folders = [folder for folder in environ.get("PATH", os.defpath).split(os.pathsep) if folder]
    for major, minor in SUPPORTED:
        for folder in [*folders, "/usr/bin", "/usr/local/bin"]:
            yield os.path.join(folder, f"python{major}.{minor}")
        for store, pattern in _stores(environ, folders):
            names = pattern.format(f"{major}.{minor}")
            yield from (str(path) for path in sorted(Path(store).glob(names)))
    yield from (os.path.join(folder, "python3") for folder in folders)


def _stores(environ, folders):
    """Yield (folder, pattern) of the interpreters that pyenv and uv keep; {} is the version."""
    home = Path(environ.get("HOME") or os.path.expanduser("~"))
    # pyenv's shims on PATH run nothing without its variables, but show where its pythons are.
    shims = [Path(folder).parent for folder in folders if Path(folder).name == "shims"]
    for root in [environ.get("PYENV_ROOT"), home / ".pyenv", *shims]:
        if root:
            yield root, "versions/{}.*/bin/python"
    yield home / ".local/share/uv/python", "cpython-{}*/bin/python3"
