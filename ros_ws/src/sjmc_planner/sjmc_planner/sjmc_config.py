"""Settings of the methods `sjmc_published` (the thesis's rule) and `sjmc` (ours)."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class SjmcConfig:
    """Zones, times and patience of SJMC. `published_*` are of `sjmc_published` alone."""

    published_danger_m: float = param(
        1.9, "`sjmc_published`: turns from what is nearer to the sensor (L_DANGER).",
        unit="m", gt=0.0, le=20.0,
    )  # fmt: skip
    published_response_s: float = param(
        2.7, "`sjmc_published`: time to notice and step aside (C = t_aware + t_avoid).",
        unit="s", gt=0.0, le=60.0,
    )  # fmt: skip
    published_end_m_s: float = param(
        0.15, "`sjmc_published`: who leaves it no more than this speed is judged not to yield; the "
        "thesis names no rule, and without one eq. 4.5 never gets to L_DANGER.",
        unit="m/s", ge=0.0, le=1.0,
    )  # fmt: skip
    danger_m: float = param(
        0.9, "Who stands nearer than this in the way is judged not to yield (L_DANGER), from the "
        "robot's front.", unit="m", gt=0.0, le=20.0,
    )  # fmt: skip
    caution_m: float = param(
        4.0, "People farther away do not count (L_CAUTION).", unit="m", gt=0.0, le=50.0
    )
    aware_s: float = param(
        1.0, "Time that a person at L_CAUTION takes to notice (t_aware); it shrinks with the "
        "distance.", unit="s", ge=0.0, le=30.0,
    )  # fmt: skip
    side_speed_m_s: float = param(
        0.7, "How fast a person who stands is expected to step aside.", unit="m/s", gt=0.0, le=3.0
    )
    end_m_s: float = param(
        0.2, "Who leaves it no more than this speed and does not move is judged not to yield.",
        unit="m/s", ge=0.0, le=1.0,
    )  # fmt: skip
    patience_s: float = param(
        3.0, "How long it waits for one person who keeps it from driving.", unit="s", ge=0.0,
        le=60.0,
    )  # fmt: skip
    bystander_patience_s: float = param(
        9.0, "For so long in all, of which a tenth of the time without is regained; then it "
        "minds them only within `bystander_line_m`.", unit="s", ge=0.0,
        le=60.0,
    )  # fmt: skip
    person_width_m: float = param(
        0.5, "What stands and is wider than this is a thing, and is not waited for.",
        unit="m", gt=0.0, le=2.0,
    )  # fmt: skip
    bystander_m: float = param(
        0.9, "Who stands this near beside the way may step into it: it comes up slowly.",
        unit="m", ge=0.0, le=3.0,
    )  # fmt: skip
    bystander_line_m: float = param(
        1.0, "Up to this distance between its front and such a person's body: who then steps out "
        "can still be met by backing.", unit="m", ge=0.0, le=10.0,
    )  # fmt: skip
    bystander_s: float = param(
        1.4, "How slowly: it would take this long to `bystander_line_m`; 0 = no regard.",
        unit="s", ge=0.0, le=10.0,
    )  # fmt: skip
    bystander_end_m_s: float = param(
        0.05, "And no slower than this: at that line it can only just back before who steps out.",
        unit="m/s", ge=0.0, le=1.0,
    )  # fmt: skip
    bystander_pass_m_s: float = param(
        0.15, "How fast it then goes past who let it come so near.", unit="m/s", ge=0.0, le=1.0
    )
    turns_in_s: float = param(
        0.65, "Who walks beside or before its way may turn into it within this time: it is at rest "
        "before they could meet; 0 = no regard.", unit="s", ge=0.0, le=10.0,
    )  # fmt: skip
    clearance_m: float = param(
        0.2, "Air to keep to people, as they are foreseen.", unit="m", ge=0.0, le=2.0
    )
    look_m: float = param(
        2.5, "A course is open if it is free so far ahead.", unit="m", gt=0.0, le=20.0
    )
    horizon_s: float = param(
        2.5, "How far ahead in time people are foreseen.", unit="s", gt=0.0, le=10.0
    )
    dodge_s: float = param(
        1.6, "Who would walk into the robot even if it stopped is waited for until this long "
        "before; then it turns away.", unit="s", ge=0.0, le=10.0,
    )  # fmt: skip
    backs_off_m: float = param(
        0.5, "How far it may back on its own way before somebody who comes too near; 0 = never.",
        unit="m", ge=0.0, le=2.0,
    )  # fmt: skip
    course_step_rad: float = param(
        0.0872665, "Between two courses that are weighed.", unit="rad", ge=0.01, le=0.6
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.caution_m <= self.danger_m:
            raise ValueError(
                f"caution_m must be > danger_m = {self.danger_m}, got {self.caution_m}"
            )
