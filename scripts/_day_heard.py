"""What was heard of a demo with goals, and what its figures are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from _day_latency import share_answered
from experiments.goal_record import GoalRecord
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2, wrap_angle

Track = list[tuple[int, SE2]]
FREE_SPACE, BEARINGS = "floor/free_space", "bearings/robots"


@dataclass(frozen=True)
class Shot:
    """A picture kept on the way.

    Attributes:
        name: Topic that it came on.
        time_s: Simulated time.
        image: RGB uint8.
    """

    name: str
    time_s: float
    image: np.ndarray


@dataclass
class DayHeard:
    """All that came so far.

    Attributes:
        record: For the judge.
        odometry: Dead reckoning, in the odom frame.
        poses: Poses by localizer, each in its own map's frame.
        grid: The newest map.
        glass: The newest layer of glass.
        maps: (stamp_ns, map, glass) as they came.
        shots: Pictures.
    """

    record: GoalRecord
    odometry: Track = field(default_factory=list)
    poses: dict[str, Track] = field(default_factory=dict)
    grid: OccupancyMap | None = None
    glass: OccupancyMap | None = None
    maps: list[tuple[int, OccupancyMap, OccupancyMap | None]] = field(default_factory=list)
    shots: list[Shot] = field(default_factory=list)


def pose_errors(track_world: Track, truth: Track) -> dict[str, Any]:
    """Return how far poses are from the truth, and how many there are.

    Nothing is fitted. Poses are compared with the truth between the stamps beside them.
    """
    rows = error_rows(track_world, truth)
    if not len(rows):
        return {"poses": 0, "mean": None, "rms": None, "max": None, "rms_deg": None}
    off, turn = rows[:, 1], rows[:, 2]
    return {
        "poses": len(rows), "mean": float(off.mean()), "rms": float(np.sqrt((off**2).mean())),
        "max": float(off.max()), "rms_deg": float(np.degrees(np.sqrt((turn**2).mean()))),
    }  # fmt: skip


def error_rows(track_world: Track, truth: Track) -> np.ndarray:
    """Return rows (stamp_s, distance, |yaw error|) of the poses within the truth, (N, 3)."""
    if not truth:
        return np.zeros((0, 3))
    stamps = np.array([stamp for stamp, _ in truth])
    rows = []
    for stamp, pose in track_world:
        k = int(np.searchsorted(stamps, stamp))
        if k == len(stamps) or (k == 0 and stamps[0] != stamp):
            continue
        true = truth[k][1]
        if stamps[k] != stamp:
            share = (stamp - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
            true = truth[k - 1][1].interpolate(true, float(share))
        off = float(np.hypot(pose.x - true.x, pose.y - true.y))
        rows.append((stamp * 1e-9, off, abs(wrap_angle(pose.yaw - true.yaw))))
    return np.array(rows).reshape(-1, 3)


def inputs_handled(
    stamps: Mapping[str, set[int]], due: Mapping[str, set[int]], ways: float | None
) -> dict[str, float | None]:
    """Return the share of its inputs that each node answered: an output bears the input's stamp.

    Args:
        stamps: Of messages heard, by topic.
        due: Of what sensors gave, by `scan`, `omni` and the names of stereo pairs.
        ways: Share of goals that a way came for.
    """
    shares = {
        "grid_mapper": share_answered(stamps.get("pose", set()), due["scan"]),
        "wavefront_planner": ways,
    }
    if "omni" in due:
        for node, topic in (("floor_detector", FREE_SPACE), ("marker_detector", BEARINGS)):
            shares[node] = share_answered(stamps.get(topic, set()), due["omni"])
    pairs = [name for name in due if name not in ("scan", "omni")]
    if pairs:
        matched = {name: stamps.get(f"stereo/{name}/disparity", set()) for name in pairs}
        num = sum(len(due[name]) for name in pairs)
        done = sum(len(due[name] & matched[name]) for name in pairs)
        candidates = stamps.get("stereo_pose/candidates", set())
        shares["stereo_matcher"] = done / num if num else None
        shares["stereo_localizer"] = share_answered(candidates, set.union(*matched.values()))
    return shares


def due_stamps(period_s: float, first_ns: int, last_ns: int) -> set[int]:
    """Return the stamps of a sensor that measures every `period_s` from time 0 on."""
    period_ns = round(period_s * 1e9)
    first = max(-(-first_ns // period_ns), 1) * period_ns
    return set(range(first, last_ns + 1, period_ns))
