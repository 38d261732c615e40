"""The planner with an error of its own, some cycles after it began to drive."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

from sjmc_planner.nodes.planner_inputs import PlannerInputs

FAILS_AFTER = 20
_obstacles = PlannerInputs.obstacles
_num_calls = 0


def _failing(self: PlannerInputs, *words: object) -> object:
    global _num_calls
    found = _obstacles(self, *words)
    _num_calls += 1
    if _num_calls > FAILS_AFTER:
        raise RuntimeError("broken on purpose")
    return found


PlannerInputs.obstacles = _failing
sys.argv[1:1] = ["sjmc_planner.nodes.local_planner_node"]
runpy.run_path(str(Path(__file__).with_name("listening.py")), run_name="__main__")
