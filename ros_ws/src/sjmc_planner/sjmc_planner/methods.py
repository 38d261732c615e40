"""The methods by name; a new one is a class with `decide` and a line here."""

from __future__ import annotations

from collections.abc import Callable

from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.known_obstacles import OnMergedScan
from sjmc_planner.omni_velocity import Cycle, OmniStatic, OmniVelocity
from sjmc_planner.planning import Method
from sjmc_planner.sjmc import Sjmc
from sjmc_planner.sjmc_published import SjmcPublished
from sjmc_planner.vff import Vff
from sjmc_planner.vfh import Vfh
from sjmc_planner.vfh_plus import VfhPlus


def make_method(config: LocalPlannerConfig) -> Method:
    """Return the method that a configuration names, minding what is known beside the scan."""
    method = METHODS[config.method](config)
    return method if isinstance(method, Sjmc) else OnMergedScan(method)


def _cycle(config: LocalPlannerConfig) -> Cycle:
    return Cycle(
        period=config.control_period_s,
        goal_tolerance=config.goal_tolerance_m,
        unseen_gap=config.unseen_gap_rad,
    )


METHODS: dict[str, Callable[[LocalPlannerConfig], Method]] = {
    "omni_velocity": lambda c: OmniVelocity(c.robot, c.omni, _cycle(c)),
    "omni_static": lambda c: OmniStatic(c.robot, c.omni, _cycle(c)),
    "sjmc": lambda c: Sjmc(c.robot, c.sjmc, c.tracking, _cycle(c)),
    "sjmc_published": lambda c: SjmcPublished(c.robot, c.sjmc, _cycle(c)),
    "vfh_plus": lambda c: VfhPlus(c.robot, c.histogram, _cycle(c)),
    "vfh": lambda c: Vfh(c.robot, c.histogram, _cycle(c)),
    "vff": lambda c: Vff(c.robot, c.histogram, _cycle(c)),
}
