"""The figures of a demo with goals: its own keys of `summary.json`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from _day_heard import Track, due_stamps, inputs_handled, pose_errors
from _day_load import LoadMeter
from _day_robot import OURS, pilot_of
from _day_watch import DayWatch
from _demo_glass import glass_recall
from _demo_report import in_world
from experiments.goal_drives import GoalDrive
from experiments.goal_judge import Surroundings, judge
from floornav_common.se2 import SE2
from sim_bridge.robot_model import RobotModel
from sim_bridge.solids import solids_of
from sim_bridge.world import World

_UNDER_WAY_NS = 500_000_000  # the last of what is measured may be under way at the end
LOCALIZERS = {"grid_mapper": True, "stereo_localizer": False}
"""Whether a localizer's map is the robot's own, which begins at the start pose."""


def day_figures(
    world: World,
    model: RobotModel,
    watch: DayWatch,
    usual: GoalDrive | None,
    loads: LoadMeter,
    wall_s: float,
    bag: Path,
) -> dict[str, Any]:
    """Return all figures; a localizer, node or run that is not there is null."""
    heard, start = watch.heard, world.robots[0].pose
    around, record = surroundings(world, model), watch.heard.record
    tracks = localizer_tracks(watch, start)
    return {
        **judge(record, around),
        "sim_s": round(record.sim_s, 3),
        "rtf": record.sim_s / wall_s if wall_s else None,
        "glass_recall": glass_recall(heard.grid, start, around.solids, record.way[:, 1:3]),
        "pose_error_m": {name: pose_errors(track, record.truth) for name, track in tracks.items()},
        "inputs_handled": _shares(world, model, watch, bag),
        "latency_ms": watch.latencies.figures(),
        "load": {
            name: {"cpu_share": load.cpu_s / wall_s if wall_s else None, "rss_mb": load.rss_mb}
            for name, load in sorted(loads.loads.items())
        },
        "baseline": None if usual is None else _baseline(usual, around, start),
    }  # fmt: skip


def surroundings(world: World, model: RobotModel) -> Surroundings:
    """Return what drives in a world are judged by."""
    outline = np.array(model.config.footprint_m)
    return Surroundings(outline, solids_of(world), world.people_model.torso_radius_m)


def localizer_tracks(watch: DayWatch, start: SE2) -> dict[str, Track]:
    """Return the poses of every localizer, and of odometry alone, in the world."""
    poses = watch.heard.poses
    found = {
        name: in_world(poses[name], start) if is_own else poses[name]
        for name, is_own in LOCALIZERS.items()
        if name in poses
    }
    return {**found, "odometry": in_world(watch.heard.odometry, start)}


def _shares(world: World, model: RobotModel, watch: DayWatch, bag: Path) -> dict[str, float | None]:
    """Return the share of its inputs that each node handled.

    For local_planner: commands over control periods since the first goal; for record: scans in the
    bag.
    """
    heard, counts = watch.heard, watch.latencies.counts
    due = _due(model, round(heard.record.sim_s * 1e9) - _UNDER_WAY_NS)
    num_sent = min(watch.goals.number + 1, heard.record.num_goals)
    ways = watch.goals.num_with_way / num_sent if num_sent > 0 else None
    periods = heard.record.sim_s / pilot_of(world, model, OURS).planner.control_period_s
    return {
        **inputs_handled(watch.latencies.stamps, due, ways),
        "local_planner": min(counts["cmd_vel"] / periods, 1.0) if periods else None,
        "record": recorded_share(bag, "/scan", len(due["scan"])),
    }


def recorded_share(bag: Path, topic: str, num_due: int) -> float | None:
    """Return how many of a topic's messages are in a bag, as a share; None without a bag."""
    path = bag / "metadata.yaml"
    if not path.exists() or not num_due:
        return None
    info = yaml.safe_load(path.read_text())["rosbag2_bagfile_information"]
    counts = {
        item["topic_metadata"]["name"]: item["message_count"]
        for item in info["topics_with_message_count"]
    }
    return min(counts.get(topic, 0) / num_due, 1.0)


def _due(model: RobotModel, last_ns: int) -> dict[str, set[int]]:
    """Return what sensors gave up to an instant, by name."""
    config, due = model.config, {}
    assert config.laser is not None
    due["scan"] = due_stamps(config.laser.period_s, 0, last_ns)
    if config.omni is not None:
        due["omni"] = due_stamps(config.omni.period_s, 0, last_ns)
    for pair in () if config.stereo is None else config.stereo.pairs:
        due[pair] = due_stamps(config.stereo.period_s, 0, last_ns)
    return due


def _baseline(usual: GoalDrive, around: Surroundings, start: SE2) -> dict[str, Any]:
    record = usual.record
    return {
        **judge(record, around),
        "glass_recall": glass_recall(usual.grid, start, list(around.solids), record.way[:, 1:3]),
        "pose_error_m": {"laser": pose_errors(in_world(usual.poses, start), record.truth)},
    }
