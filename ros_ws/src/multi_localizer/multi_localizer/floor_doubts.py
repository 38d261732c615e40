"""What speaks against a fit of the floor's border: a wrong pose must not pass for a right one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_plan import FloorPlan

MAX_OFFSET_SD = 4.0
MAX_BEYOND = 0.15
MAX_SD_M, MAX_SD_RAD = 0.25, 0.2


@dataclass(frozen=True, eq=False)
class PolishedFit:
    """A pose and how the border lies about the walls there.

    Attributes:
        pose: x, y, yaw of the camera, (3,).
        cov: Its covariance, (3, 3).
        sd_px: Deviation of a piece of border.
        offset_px: How far the border lies inside the walls.
        hidden: Share of all directions that shows no wall.
        beyond: Share of the border that lies behind the walls.
    """

    pose: np.ndarray
    cov: np.ndarray
    sd_px: float
    offset_px: float
    hidden: float
    beyond: float


def doubt(fit: PolishedFit, plan: FloorPlan, config: FloorFitConfig) -> str:
    """Return why a fit is no pose; "" if nothing speaks against it."""
    if not plan.contains(fit.pose[0], fit.pose[1]):
        return "the border fits only outside of the plan"
    if fit.hidden > config.max_hidden:
        return f"{fit.hidden:.0%} of the directions show no wall of the plan"
    if fit.beyond > MAX_BEYOND:
        return f"{fit.beyond:.0%} of the border lies where the plan has no floor"
    if abs(fit.offset_px) > MAX_OFFSET_SD * max(config.offset_sd_px, config.border_sd_px):
        return f"the border lies {fit.offset_px:.1f} px inside the walls"
    if fit.sd_px >= config.max_sd_px:
        return f"the border scatters by {fit.sd_px:.1f} px about the walls"
    x, y, yaw = np.sqrt(np.diag(fit.cov))
    if max(x, y) > MAX_SD_M or yaw > MAX_SD_RAD:
        return f"the border does not determine the pose: {x:.2f} m, {y:.2f} m, {yaw:.2f} rad"
    return ""
