"""Start a node from its executable so that a signal ends it cleanly from the first moment on.

Importing ROS and the numeric libraries takes a second or more. A signal that comes meanwhile ends
the process at once, with exit code 0 and without a word: nothing has begun that could be left
half done. From `run_node` on the node stops as `floornav_common.ros.main` says, with 0 as well.
Nothing is imported here that takes time.
"""

from __future__ import annotations

import importlib
import os
import signal
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def start_node(module: str) -> int:
    """Import a node's module and run its `main`.

    Args:
        module: Full name, such as `grid_mapper.nodes.grid_mapper_node`.

    Returns:
        The exit code of its `main`.
    """
    leave_on_signal()
    code: int = importlib.import_module(module).main()
    return code


def leave_on_signal() -> None:
    """End the process with 0 on SIGINT and SIGTERM, until the node's `main` replaces that."""
    for signum in _SIGNALS:
        signal.signal(signum, _leave)


def _leave(_signum: int, _frame: FrameType | None) -> None:
    os._exit(0)
