"""The filter's noise for the five-robot recording, judged without ground truth.

Each robot is located by landmarks alone; its bearings to other robots are withheld and only asked
how likely they were. What they say depends on the poses of both robots, so their likelihood is
greatest where the poses are best and their covariances true. `travel_noise` and `drag_sd` stand
where the mean log density of the recording's first half is greatest, on a grid of factors of 1.4
and 2; the other values were searched one after another before, on all of it, and rounded;
`scale_sd` and `offset_walk` were set by hand. The table has the density of the first half for half
and for twice each value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from experiments.mrclam_recording import TeamRecording
from experiments.mrclam_runs import NOISE, ODOMETRY_DELAY_S, run_filter
from floornav_common.reporting import Section, Table
from multi_localizer.team_filter_config import TeamFilterConfig

_VALUES = (
    "bearing_sd_rad", "repeat_s", "travel_noise", "sideways_noise", "turn_noise_way", "turn_noise",
    "scale_walk", "scale_sd", "offset_walk", "drag_sd",
)  # fmt: skip
_FALSE = 0.01
_VIEW_RAD = 1.2


def first_half(recording: TeamRecording) -> TeamRecording:
    """Return the recording up to its middle: all that the choice of the noise may look at."""
    middle = 0.5 * (recording.start + recording.end)
    robots = {
        k: replace(
            log,
            odometry=log.odometry[log.odometry[:, 0] <= middle],
            looks=log.looks[log.looks[:, 0] <= middle],
        )
        for k, log in recording.robots.items()
    }
    return replace(recording, robots=robots)


def log_density(recording: TeamRecording, config: TeamFilterConfig, delay: float) -> float:
    """Return the mean log density of the withheld bearings to robots.

    A bearing is false with a probability of 1 %, and then anywhere in the picture.
    """
    logs: list[float] = []

    def judge(off: float, var: float) -> None:
        fits = np.exp(-0.5 * off * off / var) / np.sqrt(2.0 * np.pi * var)
        logs.append(float(np.log((1.0 - _FALSE) * fits + _FALSE / _VIEW_RAD)))

    run_filter(recording, "alone", config, delay, on_withheld=judge)
    return float(np.mean(logs)) if logs else float("nan")


def noise_section(
    recording: TeamRecording, on_row: Callable[[str, int, int], None] = lambda *_: None
) -> tuple[Section, dict[str, list[float]]]:
    """Return the table of log densities at half, once and twice each value, and its numbers."""
    names = [*_VALUES, "odometry_delay_s"]
    recording = first_half(recording)
    here = log_density(recording, NOISE, ODOMETRY_DELAY_S)
    found: dict[str, list[float]] = {}
    rows = []
    for k, name in enumerate(names):
        on_row(name, k + 1, len(names))
        value = getattr(NOISE, name, ODOMETRY_DELAY_S)
        around = [
            log_density(recording, NOISE, factor * value)
            if name == "odometry_delay_s"
            else log_density(recording, replace(NOISE, **{name: factor * value}), ODOMETRY_DELAY_S)
            for factor in (0.5, 2.0)
        ]
        found[name] = [around[0], here, around[1]]
        rows.append([name, f"{value:g}", *(f"{log:.3f}" for log in found[name])])
    text = (__doc__ or "").split("\n\n", 1)[1]
    header = ["value", "used", "log density at half", "as used", "at twice"]
    return Section("Noise, chosen without ground truth", [text, Table(header, rows)]), found
