"""A graph of child processes, beside one node of this process that hears them."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from _processes import Processes
from floornav_common.ros.main import make_executor

_SPIN_S = 0.05

WatchT = TypeVar("WatchT", bound=Node)


@contextlib.contextmanager
def watched(
    make_watch: Callable[[], WatchT], log_dir: Path
) -> Iterator[tuple[WatchT, Processes, Callable[[], None]]]:
    """Hear what child processes say over DDS until the block is left, which ends them.

    Args:
        make_watch: Makes the node that hears, once DDS is there.
        log_dir: Folder for the children's logs.

    Yields:
        The node, the children (none yet), and a function that hears for 0.05 s.
    """
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        watch = make_watch()
        executor = make_executor()
        executor.add_node(watch)

        def spin() -> None:
            # One call handles one message or a batch, as the executor has it.
            end = time.monotonic() + _SPIN_S
            while time.monotonic() < end:
                executor.spin_once(timeout_sec=0.02)

        try:
            with Processes(log_dir, os.environ) as children:
                yield watch, children, spin
        finally:
            watch.destroy_node()
    finally:
        rclpy.try_shutdown()
