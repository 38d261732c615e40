"""Nav2's FollowPath for tests: the installed nav2_msgs, or that one definition built beside.

Built once into a folder of the environment and found by paths that only a test's processes get, so
that nothing else takes it for an installed Nav2.
"""

from __future__ import annotations

import fcntl
import hashlib
import importlib.util
import os
import shutil
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE = HERE / "nav2_interfaces"
SCRIPTS = HERE.parent.parent / "scripts"


class CannotBuildError(Exception):
    """This machine cannot compile interfaces; the text says why."""


def nav2_environment() -> dict[str, str]:
    """Return what a process needs in its environment to import nav2_msgs.

    Raises:
        CannotBuildError: If it is not installed and cannot be built.
    """
    if importlib.util.find_spec("nav2_msgs") is not None:
        return {}
    prefix = Path(sys.prefix)
    files = sorted(path for path in SOURCE.rglob("*") if path.is_file())
    key = hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:12]
    built = prefix / "test-interfaces" / f"nav2_msgs-{key}"
    built.parent.mkdir(exist_ok=True)
    with open(built.parent / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not built.exists():
            _build(prefix, built)
    python = next((built / "lib").glob("python*/site-packages"))
    return {
        name: os.pathsep.join([str(path), *filter(None, [os.environ.get(name)])])
        for name, path in (
            ("PYTHONPATH", python), ("LD_LIBRARY_PATH", built / "lib"), ("AMENT_PREFIX_PATH", built)
        )
    }  # fmt: skip


def _build(prefix: Path, built: Path) -> None:
    """Build as the environment's tf2_msgs is built, into a folder of its own."""
    sys.path.insert(0, str(SCRIPTS))
    try:
        import _tf2_msgs as builder
    finally:
        sys.path.remove(str(SCRIPTS))
    cmake = builder.find_cmake(prefix)
    if cmake is None:
        raise CannotBuildError("no cmake found")
    with tempfile.TemporaryDirectory(prefix="floornav_nav2_msgs_") as scratch:
        folder = Path(scratch)
        facts, source = builder._interpreter_facts(prefix), builder.SOURCE_DIR
        staged, log = folder / "install", built.parent / "nav2_msgs_build.log"
        try:
            builder.check_compiler()
            overlay = builder._overlay_with_local_paths(prefix, folder / "overlay", facts)
            builder.SOURCE_DIR = SOURCE
            builder._run_cmake(cmake, prefix, overlay, folder / "build", staged, facts, log)
        except builder.BuildToolMissingError as error:
            raise CannotBuildError(str(error)) from error
        finally:
            builder.SOURCE_DIR = source
        shutil.move(staged, built)
