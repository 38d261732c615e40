"""Starting pybullet."""

from __future__ import annotations

import importlib.util
import os
import sys
from typing import Any


class PybulletMissingError(RuntimeError):
    """Pybullet is not installed; the text is one line for the user."""


def require_pybullet() -> None:
    """Check that a world can be simulated here.

    Raises:
        PybulletMissingError: Pybullet is not installed.
    """
    if importlib.util.find_spec("pybullet") is None:
        raise PybulletMissingError(
            "sim_bridge needs pybullet, which has a ready wheel for Python 3.11 only: "
            "use Python 3.11, or build it (see the README of sim_bridge)"
        )


def _import_quietly() -> Any:
    """Import pybullet without the line that its C code writes to stderr."""
    sys.stderr.flush()
    kept, null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 2)
    try:
        import pybullet
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(null)
    return pybullet


def connect(has_window: bool) -> tuple[Any, int]:
    """Return pybullet and a client of a new engine, with or without a window."""
    require_pybullet()
    pybullet = _import_quietly()
    client = pybullet.connect(pybullet.GUI if has_window else pybullet.DIRECT)
    if client < 0:
        raise RuntimeError("pybullet could not open its window: is there a display?")
    return pybullet, client
