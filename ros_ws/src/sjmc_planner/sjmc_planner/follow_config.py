"""Settings of `goal_source: follow_path`: when a planner gives a path up."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class FollowConfig:
    """When Nav2's action ends without the goal (with `goal_source: follow_path`)."""

    failure_tolerance_s: float = param(
        2.0, "An input that is missing for longer ends it (TF_ERROR, CONTROLLER_TIMED_OUT).",
        unit="s", ge=0.0,
    )  # fmt: skip
    patience_s: float = param(
        15.0, "Standing before something for longer ends it (PATIENCE_EXCEEDED).",
        unit="s", gt=0.0,
    )  # fmt: skip
    progress_m: float = param(
        0.3, "It gets on if it is this far from where it was.", unit="m", gt=0.0
    )
    progress_s: float = param(
        30.0, "Not getting on for longer ends it (FAILED_TO_MAKE_PROGRESS).", unit="s", gt=0.0
    )
    feedback_period_s: float = param(0.1, "Time between feedbacks.", unit="s", gt=0.0)

    def __post_init__(self) -> None:
        validate(self)
