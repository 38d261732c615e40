"""Whether pybullet's window can be shown."""

from __future__ import annotations

import os
from collections.abc import Mapping

NO_DISPLAY = "needs a display, and there is none"


def has_display(environ: Mapping[str, str] = os.environ) -> bool:
    """Tell whether there is a display for a window."""
    return bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))
