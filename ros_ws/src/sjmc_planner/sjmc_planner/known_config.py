"""Settings of what `local_planner` takes from a map beside the scan."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class KnownConfig:
    """Obstacles that the scan does not show, such as glass: of a map, and heard by sonars."""

    minds_map: bool = param(
        True, "Keep off what the topic `map/glass` holds for an obstacle, once it has come.",
        read_only=True,
    )  # fmt: skip
    reach_m: float = param(
        3.0, "What is farther from the robot does not count.", unit="m", gt=0.0, le=50.0
    )
    occupied_from: int = param(
        65, "Cells of this occupancy and more are obstacles.", unit="%", ge=1, le=100
    )

    sonar_topics: tuple[str, ...] = param(
        ("sonar",), "Topics of ultrasonic sonars (Range) to listen to close by; empty for none.",
        read_only=True,
    )  # fmt: skip
    sonar_timeout_s: float = param(
        1.0, "Stops if no sonar was heard for this long, once one was.", unit="s", gt=0.0
    )
    echo_m: float = param(
        1.2, "Echoes from nearer than this that nothing in the scan explains are obstacles.",
        unit="m", ge=0.0, le=10.0,
    )  # fmt: skip
    pane_m: float = param(
        1.0, "What they come from goes on so far to either side, or to the next post; half as far "
        "until three echoes tell its line.", unit="m", ge=0.0, le=5.0,
    )  # fmt: skip
    echo_hold_s: float = param(2.0, "For so long after they were heard.", unit="s", ge=0.0, le=60.0)

    def __post_init__(self) -> None:
        validate(self)
