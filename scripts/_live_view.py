"""The live view beside a demo: the node, and the address to open."""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from _processes import Processes
from floornav_common.live_view.config import LiveViewConfig
from floornav_common.reporting import say
from sim_bridge.robot_model import RobotModel

_NAME = "live_view"
_START_TIMEOUT_S = 60.0


def start_live_view(
    children: Processes, log_dir: Path, model: RobotModel, spin: Callable[[], None]
) -> None:
    """Start the node for a robot, wait for it, and say where to look.

    Args:
        children: The demo's processes.
        log_dir: Folder of their logs.
        model: The robot, for its outline.
        spin: What the demo does while it waits.
    """
    numbers = ", ".join(f"{v:.4f}" for v in np.ravel(model.config.footprint_m))
    told = {"use_sim_time": "true", "outline_m": f"[{numbers}]", "port": str(_port())}
    words = [word for key, value in told.items() for word in ("-p", f"{key}:={value}")]
    module = "floornav_common.nodes.live_view_node"
    children.start(_NAME, [sys.executable, "-m", module, "--ros-args", *words])
    children.wait_for_line(_NAME, "in a browser", _START_TIMEOUT_S, spin)
    found = re.search(r"http://\S+", (log_dir / f"{_NAME}.log").read_text())
    say(f"live view: open {found.group() if found else '?'} in a browser on this machine")


def _port() -> int:
    """Return the usual port, or 0 for any where it is taken."""
    usual = LiveViewConfig().port
    try:
        socket.create_server(("127.0.0.1", usual)).close()
    except OSError:
        return 0
    return usual
