"""Learn the floor's color from pictures; `--help` tells the options."""

import sys

from _environment import ensure_environment

ensure_environment()

from floor_perception.learn_colors import main  # noqa: E402
from floornav_common.reporting import run_command  # noqa: E402

if __name__ == "__main__":
    sys.exit(run_command(main))
