"""Settings of the node `wavefront_planner`."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class WavefrontConfig:
    """Settings of ways over a map (LaValle 2006, wavefront propagation, with weights)."""

    radius_m: float = param(
        0.085, "Circle around `base_frame` that holds the whole robot.", unit="m", gt=0.0
    )
    margin_m: float = param(0.05, "Air to keep beyond that circle.", unit="m", ge=0.0)
    occupied_from: int = param(
        65, "Cells of this occupancy and more are obstacles.", unit="%", ge=1, le=100
    )
    unknown_weight: float = param(
        3.0, "Cost of a cell that is not known beside a free one; 0: never through the unknown.",
        ge=0.0, le=1000.0,
    )  # fmt: skip
    near_weight: float = param(
        4.0, "Cost added beside an obstacle; falls to 0 at `near_m`.", ge=0.0, le=1000.0
    )
    near_m: float = param(
        0.4,
        "Farther than this from what it must not touch, a cell costs no more.",
        unit="m",
        ge=0.0,
    )
    goal_search_m: float = param(
        0.2, "A goal that the robot cannot stand on is moved to the nearest place up to this.",
        unit="m", ge=0.0,
    )  # fmt: skip
    start_search_m: float = param(
        0.5, "The same for where the robot is, so that it may leave what it stands too near to.",
        unit="m", ge=0.0,
    )  # fmt: skip
    spacing_m: float = param(0.1, "Distance of the path's points.", unit="m", ge=0.01)
    goal_tolerance_m: float = param(
        0.15, "This near the way is done: no new one after that.", unit="m", gt=0.0
    )
    better_share: float = param(
        0.1, "A new map's way takes the place of one that is still free if it is shorter by this "
        "share.", ge=0.0, le=1.0,
    )  # fmt: skip
    off_path_m: float = param(
        0.7, "Farther than this from its path, it makes a new one.", unit="m", gt=0.0
    )
    pose_timeout_s: float = param(0.5, "Waits if the pose on the map is older.", unit="s", gt=0.0)

    def __post_init__(self) -> None:
        validate(self)
