"""Make a voxel map for stereo_localizer; `--help` tells the options."""

import sys
from functools import partial

from _environment import ensure_environment

ensure_environment()

from experiments.stereo_world_map import map_of_world  # noqa: E402
from floornav_common.reporting import run_command  # noqa: E402
from multi_localizer.make_voxel_map import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(run_command(partial(main, world_maker=map_of_world)))
