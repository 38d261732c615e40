"""Runs over the five-robot recording: causal, every picture in the order of its stamp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from experiments.mrclam_recording import NUM_ROBOTS, TeamRecording
from floornav_common.se2 import SE2
from multi_localizer.team_filter import TeamFilter
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_sightings import Sighting

ODOMETRY_DELAY_S = 0.28
"""The odometry holds commanded velocities; the robots follow them so much later."""

NOISE = TeamFilterConfig(
    bearing_sd_rad=0.0052,
    repeat_s=4.0,
    scale_sd=0.03,
    drag_sd=2.0,
    travel_noise=0.035,
    sideways_noise=0.015,
    turn_noise_way=0.04,
    turn_noise=0.084,
    scale_walk=0.003,
)
"""Chosen without ground truth: see `mrclam_noise`."""

OUTPUT_EVERY_S = 0.2
_NOBODY = "nobody of the team"
MODES = ("alone", "named", "nameless")


@dataclass(eq=False)
class Track:
    """What a run said, at every output instant.

    Attributes:
        times: Output instants, s, shape (T,).
        poses: x, y, yaw, NaN while not located, shape (T, R, 3).
        covs: Their covariances, shape (T, R, 3, 3).
        num_right: Nameless bearings whose robot was told rightly.
        num_wrong: And wrongly, those of robots that take no part included.
        num_open: And not at all, of robots that take part.
        num_used: Bearings that corrected the team.
        num_refused: Bearings left out by the gate.
        num_lost: Times that a robot was lost.
        errors: What the sensors do wrong at the end, by robot, as in `SensorErrors`.
    """

    times: np.ndarray
    poses: np.ndarray
    covs: np.ndarray
    num_right: int = 0
    num_wrong: int = 0
    num_open: int = 0
    num_used: int = 0
    num_refused: int = 0
    num_lost: int = 0
    errors: dict[int, tuple[float, ...]] = field(default_factory=dict)


def output_times(recording: TeamRecording) -> np.ndarray:
    """Return the instants at which runs are compared, s."""
    return np.arange(recording.start, recording.end, OUTPUT_EVERY_S)


def run_filter(
    recording: TeamRecording,
    mode: str,
    config: TeamFilterConfig = NOISE,
    delay: float = ODOMETRY_DELAY_S,
    *,
    on_progress: Callable[[float], None] = lambda share: None,
    on_withheld: Callable[[float, float], None] | None = None,
) -> Track:
    """Drive the team's filter through the recording.

    Args:
        recording: Its ground truth is not looked at.
        mode: `alone`: bearings to landmarks only; `named`: also to robots; `nameless`: also, but
            which robot it is has to be told by geometry.
        config: Of the filter.
        delay: Of the odometry, s.
        on_progress: Called now and then with the share done.
        on_withheld: Called with how far each bearing to a robot is off and its variance, for
            bearings that the mode does not use.
    """
    numbers = tuple(recording.robots)
    landmarks = {_landmark(k): point for k, point in recording.landmarks.items()}
    team = TeamFilter([_name(k) for k in numbers], landmarks, config)
    times = output_times(recording)
    pictures = _pictures(recording)
    stamps = np.unique(np.concatenate([times, [picture[0] for picture in pictures]]))
    motions = {k: _motions(recording, k, stamps, delay) for k in numbers}
    track = Track(
        times, np.full((len(times), len(numbers), 3), np.nan),
        np.full((len(times), len(numbers), 3, 3), np.nan),
    )  # fmt: skip
    next_picture, row, located = 0, 0, 0
    for step, stamp in enumerate(stamps):
        stamp_ns = round((stamp - recording.start) * 1e9)
        for k in numbers:
            team.predict(_name(k), motions[k][step], stamp_ns)
        while next_picture < len(pictures) and pictures[next_picture][0] == stamp:
            _, robot, subjects, bearings = pictures[next_picture]
            next_picture += 1
            if on_withheld is not None:
                is_named = np.isin(subjects, numbers)
                _withhold(team, robot, subjects[is_named], bearings[is_named], on_withheld)
            _take(team, track, mode, numbers, (robot, subjects, bearings), stamp_ns)
        if row < len(times) and times[row] == stamp:
            located = _write(track, row, team, numbers, located)
            row += 1
            if row % 50 == 0:
                on_progress(row / len(times))
    for k in numbers:
        e = team.errors_of(_name(k))
        track.errors[k] = (e.offset, e.scale, e.travel, e.turn, e.curve, e.drag)
    return track


def _write(track: Track, row: int, team: TeamFilter, numbers: tuple[int, ...], located: int) -> int:
    """Write the estimates of an output instant; return how many robots are located."""
    estimates = team.estimates()
    track.num_lost += max(located - len(estimates), 0)
    for column, k in enumerate(numbers):
        if _name(k) in estimates:
            estimate = estimates[_name(k)]
            track.poses[row, column] = estimate.pose.as_array()
            track.covs[row, column] = estimate.cov
    return len(estimates)


def dead_reckoning(recording: TeamRecording, start: Track, delay: float) -> Track:
    """Return the odometry alone, from the first pose that a run found for each robot."""
    poses = np.full_like(start.poses, np.nan)
    for column, k in enumerate(recording.robots):
        is_located = np.isfinite(start.poses[:, column, 0])
        if not is_located.any():
            continue
        first = int(np.argmax(is_located))
        driven = recording.robots[k].dead_reckoned(start.times, delay)
        T_map_odom = SE2(*start.poses[first, column]) @ SE2(*driven[first]).inverse()
        poses[first:, column, :2] = T_map_odom @ driven[first:, :2]
        poses[first:, column, 2] = driven[first:, 2] + T_map_odom.yaw
    return Track(start.times, poses, np.full_like(start.covs, np.nan))


_Picture = tuple[float, int, np.ndarray, np.ndarray]


def _pictures(recording: TeamRecording) -> list[_Picture]:
    """Return stamp, robot, subjects and bearings of every picture, in the order of stamps."""
    pictures: list[_Picture] = []
    for k, log in recording.robots.items():
        stamps, first = np.unique(log.looks[:, 0], return_index=True)
        for stamp, rows in zip(stamps, np.split(log.looks, first[1:]), strict=True):
            pictures.append((float(stamp), k, rows[:, 1].astype(int), rows[:, 2]))
    return sorted(pictures, key=lambda picture: picture[:2])


def _motions(recording: TeamRecording, robot: int, stamps: np.ndarray, delay: float) -> list[SE2]:
    poses = [SE2(*pose) for pose in recording.robots[robot].dead_reckoned(stamps, delay)]
    steps = [a.between(b) for a, b in zip(poses, poses[1:], strict=False)]
    return [SE2.identity(), *steps]


def _take(
    team: TeamFilter,
    track: Track,
    mode: str,
    numbers: tuple[int, ...],
    picture: tuple[int, np.ndarray, np.ndarray],
    stamp_ns: int,
) -> None:
    """Give the filter what a mode allows of a picture, and count what became of it."""
    robot, subjects, bearings = picture
    others = tuple(_name(k) for k in numbers if k != robot)
    sightings, truly = [], []
    for subject, bearing in zip(subjects, bearings, strict=True):
        if subject > NUM_ROBOTS:
            sightings.append(Sighting(float(bearing), (_landmark(subject),)))
            truly.append("")
        elif mode == "nameless" and subject not in numbers:  # takes no part: a false detection
            sightings.append(Sighting(float(bearing), others))
            truly.append(_NOBODY)
        elif mode != "alone" and subject in numbers:
            meanings = others if mode == "nameless" else (_name(subject),)
            sightings.append(Sighting(float(bearing), meanings))
            truly.append(_name(subject) if mode == "nameless" else "")
    looks = team.update(_name(robot), sightings, stamp_ns)
    track.num_used += int(looks.is_used.sum())
    track.num_refused += int((np.isfinite(looks.deviations) & ~looks.is_used).sum())
    for meaning, name in zip(looks.meanings, truly, strict=True):
        if name:
            track.num_right += meaning == name
            track.num_wrong += meaning not in (name, "")
            track.num_open += meaning == "" and name != _NOBODY


def _withhold(
    team: TeamFilter,
    robot: int,
    subjects: np.ndarray,
    bearings: np.ndarray,
    on_withheld: Callable[[float, float], None],
) -> None:
    for subject, bearing in zip(subjects, bearings, strict=True):
        expected = team.expect(_name(robot), Sighting(float(bearing), (_name(subject),)))
        if expected is not None:
            on_withheld(*expected)


def _name(robot: int) -> str:
    return f"robot{robot}"


def _landmark(subject: int) -> str:
    return f"landmark{subject}"
