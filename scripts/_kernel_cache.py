"""Forgets compiled kernels whose sources have changed.

numba compares a cached kernel with the file it stands in, not with the files of the kernels that
it calls: after an update of one of those it would go on running the old code without a word.
"""

import contextlib
import hashlib
import json
import os
from pathlib import Path

SOURCES = Path(__file__).resolve().parent.parent
_STAMPS = "sources.json"


def forget_changed_kernels(cache, sources=SOURCES):
    """Delete from numba's cache what was compiled from other sources than there are now.

    A package's kernels call those of that package only; the experiments' call everybody's.

    Args:
        cache: NUMBA_CACHE_DIR; made if it is not there.
        sources: The checkout.
    """
    packages = sorted((Path(sources) / "ros_ws" / "src").glob("*/package.xml"))
    folders = [path.parent for path in packages]
    now = {folder.name: _digest(folder) for folder in folders}
    now["experiments"] = hashlib.sha256(json.dumps(now).encode()).hexdigest()
    before = _read(Path(cache) / _STAMPS)
    if now == before:
        return
    changed = {name for name in now if before.get(name) != now[name]}
    for folder in folders:
        if folder.name in changed:
            for name in {path.parent.name for path in _kernel_files(folder)}:
                _forget(Path(cache), name)
    _forget(Path(cache), "experiments")
    _write(Path(cache) / _STAMPS, now)


def _kernel_files(folder):
    """Return the files of a package that hold kernels, in order."""
    files = sorted(folder.glob(f"{folder.name}/**/*.py"))
    return [path for path in files if b"numba" in path.read_bytes()]


def _digest(folder):
    """Return a digest of all kernels of a package."""
    digest = hashlib.sha256()
    for path in _kernel_files(folder):
        digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _forget(cache, name):
    """Delete the files of numba's folders `<name>_<hash>`; the folders may be in use."""
    for path in cache.glob(f"{name}_*/*.nb[ic]"):
        with contextlib.suppress(OSError):  # another process was quicker
            path.unlink()


def _read(path):
    """Return the stamps written before; none if there are none or they cannot be read."""
    try:
        stamps = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return stamps if isinstance(stamps, dict) else {}


def _write(path, stamps):
    """Write the stamps whole or not at all; a folder that is read-only keeps what it has."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f"{path.name}.{os.getpid()}")
        part.write_text(json.dumps(stamps))
        part.replace(path)
