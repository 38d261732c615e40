"""Test messages against their consumers' published rules; `--help` tells the options."""

import sys

from _environment import ensure_environment

ensure_environment(needs="node")

from floornav_common.reporting import run_command  # noqa: E402
from grid_mapper.nodes.check_contract import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(run_command(main))
