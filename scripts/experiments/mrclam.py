"""The real five-robot recording: where the team is, from bearings and odometry, beside the truth.

Five robots drive for 15 minutes among 15 landmarks (UTIAS multi-robot cooperative localization and
mapping, dataset 6). Only bearings are used, never ranges; landmarks' positions and identities are
given. Everything is causal. Robots start from bearings alone: no pose is given, and ground truth
is looked at only to judge. Errors are not aligned; the first 30 s are left out.

Rows: odometry alone (from the pose at which the robot alone found its start), each robot alone (its
own bearings to landmarks), and the team (also bearings to robots, one joint filter), with the
robots' identities given and told by geometry.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from experiments.mrclam_measures import Errors, errors_of
from experiments.mrclam_noise import noise_section
from experiments.mrclam_pictures import draw_errors, draw_ways
from experiments.mrclam_recording import NUM_ROBOTS, TeamRecording, load_recording
from experiments.mrclam_runs import ODOMETRY_DELAY_S, Track, dead_reckoning, run_filter
from experiments.mrclam_triangles import Triangles, count_triangles
from floornav_common.reporting import Picture, Progress, Section, Table, UserError
from floornav_common.ros.threads import limit_threads

_ALL = tuple(range(1, NUM_ROBOTS + 1))
_TEXTS = {
    "odometry": "odometry alone",
    "alone": "each robot alone",
    "team_named": "team, identities given",
    "team_nameless": "team, identities by geometry",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument("--data", type=Path, required=True, metavar="DIR", help="the recording")
    parser.add_argument(
        "--robots", type=_robots, default=_ALL, metavar="N,N,...",
        help="robots that take part (default: 1,2,3,4,5)",
    )  # fmt: skip
    parser.add_argument(
        "--anonymous", action="store_true",
        help="`team` of the summary is the run whose robots are told by geometry",
    )  # fmt: skip
    parser.add_argument(
        "--noise", action="store_true",
        help="also judge each value of the noise at half and twice, without ground truth (long)",
    )  # fmt: skip


def _robots(text: str) -> tuple[int, ...]:
    try:
        robots = tuple(int(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list such as 1,2,5") from None
    if not set(robots) <= {*_ALL} or len(set(robots)) < len(robots):
        raise argparse.ArgumentTypeError(f"robots are 1 to {NUM_ROBOTS}, each once, got {text}")
    return tuple(sorted(robots))


def check(args: argparse.Namespace) -> None:
    """Read the recording before a folder is made.

    Raises:
        UserError: If it is missing, cut short or not what it should be.
    """
    args.recording = load_recording(args.data, args.robots)
    if all(not np.isfinite(log.truth).any() for log in args.recording.robots.values()):
        raise UserError(f"{args.data} holds no ground truth")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Run all methods, judge them and return the report."""
    limit_threads(1)
    recording: TeamRecording = args.recording
    values.update(
        data=str(args.data), robots=list(args.robots), is_anonymous=args.anonymous, ate_m=None,
        identified_share=None, wrong_share=None, triangles_share=None,
    )  # fmt: skip
    tracks: dict[str, Track] = {}
    with Progress("mrclam", 3.0, is_quiet=args.quiet) as progress:
        for k, (row, mode) in enumerate(
            (("alone", "alone"), ("team_named", "named"), ("team_nameless", "nameless"))
        ):
            tracks[row] = run_filter(
                recording, mode,
                on_progress=lambda share, k=k, row=row: progress.update(k + share, _TEXTS[row]),  # type: ignore[misc]
            )  # fmt: skip
        progress.update(3.0, "judging", is_last=True)
    tracks["odometry"] = dead_reckoning(recording, tracks["alone"], ODOMETRY_DELAY_S)
    tracks["team"] = tracks["team_nameless" if args.anonymous else "team_named"]
    errors = {row: errors_of(recording, track) for row, track in tracks.items()}
    triangles = count_triangles(recording, tracks["alone"], ODOMETRY_DELAY_S)
    _fill(values, recording, tracks, errors, triangles)
    sections = _sections(args, recording, tracks, errors, triangles)
    if args.noise:
        with Progress("noise", None, is_quiet=args.quiet) as progress:
            section, values["noise_log_density"] = noise_section(
                recording, lambda name, k, total: progress.update(k, f"{name}, {k} of {total}")
            )
        sections.append(section)
    return sections


def _fill(
    values: dict[str, Any],
    recording: TeamRecording,
    tracks: dict[str, Track],
    errors: dict[str, Errors],
    triangles: Triangles,
) -> None:
    """Write the keys of the summary."""
    names = [str(k) for k in recording.robots]
    keys = {
        "ate_m": "ate", "yaw_rmse_deg": "yaw_deg", "worst_m": "worst", "nees": "nees",
        "located_share": "located_share", "nees_within_95_share": "sure_share",
    }  # fmt: skip
    for key, attribute in keys.items():
        values[key] = {
            row: {"mean": float(np.mean(found)), **dict(zip(names, found.tolist(), strict=True))}
            for row, found in ((row, getattr(e, attribute)) for row, e in errors.items())
        }
    nameless = tracks["team_nameless"]
    total = nameless.num_right + nameless.num_wrong + nameless.num_open
    values["bearings_to_robots"] = total
    values["identified_share"] = nameless.num_right / total if total else None
    values["wrong_share"] = nameless.num_wrong / total if total else None
    values["triangles_share"] = triangles.num_found / triangles.num_instants
    values["triangles"] = vars(triangles)
    values["start_s"] = {
        row: dict(zip(names, errors[row].first_s.tolist(), strict=True)) for row in _TEXTS
    }
    values["num_lost"] = {row: tracks[row].num_lost for row in _TEXTS if row != "odometry"}


def _sections(
    args: argparse.Namespace,
    recording: TeamRecording,
    tracks: dict[str, Track],
    errors: dict[str, Errors],
    triangles: Triangles,
) -> list[Section]:
    """Return tables and pictures."""
    robots = [f"robot {k}" for k in recording.robots]
    shown = {row: tracks[row] for row in ("odometry", "alone", "team")}
    ways = draw_ways(args.out_dir / "ways.png", recording, shown)
    over_time = draw_errors(args.out_dir / "errors.png", recording, shown, errors)
    ate = [
        [_TEXTS[row], *(f"{v:.3f}" for v in (errors[row].ate.mean(), *errors[row].ate))]
        for row in _TEXTS
    ]
    more = [
        [
            _TEXTS[row], f"{e.yaw_deg.mean():.1f}", f"{e.worst.max():.2f}",
            " ".join(f"{v:.2f}" for v in e.located_share),
            " ".join(f"{v:.0f}" for v in e.first_s),
            " ".join(_number(v, 1) for v in e.nees), _number(float(np.mean(e.sure_share)), 2),
        ]
        for row, e in ((row, errors[row]) for row in _TEXTS)
    ]  # fmt: skip
    header = ["", "yaw RMSE, deg", "worst, m", "located, share", "start, s", "NEES", "within 95 %"]
    return [
        Section("Position error (ATE, m), unaligned", [
            __doc__ or "", Table(["", "mean", *robots], ate), Table(header, more),
            "NEES is 3 on average if the covariances are true, and 95 % of it lies below 7.8. "
            "Errors count where the robot's pose is known; `located` is the share of that.",
            Picture(over_time, "Position error over time."), Picture(ways, "Ways; truth black."),
        ]),
        Section("Who is who", [_who(tracks["team_nameless"], triangles)]),
        Section("What the sensors do wrong, as estimated at the end", [_wrong(tracks["team"])]),
    ]  # fmt: skip


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else "-"


def _who(track: Track, triangles: Triangles) -> str:
    total = track.num_right + track.num_wrong + track.num_open
    if total == 0:
        return "No robot that takes part sees another."
    return (
        f"Of {total} bearings to robots without names geometry tells {track.num_right / total:.1%} "
        f"rightly, {track.num_wrong / total:.2%} wrongly and leaves the rest open. The published "
        f"step, once a second on the bearings of the last second, found a triangle at "
        f"{triangles.num_found} of {triangles.num_instants} instants, every robot of it rightly "
        f"named at {triangles.num_right}. Two robots truly saw each other at "
        f"{triangles.num_pairs}, three at {triangles.num_mutual}: the cameras "
        f"see 34 degrees to each side."
    )


def _wrong(track: Track) -> Table:
    header = [
        "robot",
        "bearing offset, deg",
        "bearing scale",
        "way",
        "turn",
        "curve, rad/m",
        "way at 0.4 rad/s",
    ]
    rows = [
        [
            str(robot), f"{np.degrees(e[0]):.2f}", *(f"{1.0 + v:.3f}" for v in e[1:4]),
            f"{e[4]:.3f}", f"{1.0 + e[2] + 0.4 * e[5]:.3f}",
        ]
        for robot, e in track.errors.items()
    ]  # fmt: skip
    return Table(header, rows)
