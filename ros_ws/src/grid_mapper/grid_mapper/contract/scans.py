"""Rules for LaserScan and Range."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from grid_mapper.contract.rule import Rule, Topic, Verdict, judge_each, of_problems

_SLAM = "slam_toolbox src/laser_utils.cpp, lib/karto_sdk Karto.h: LaserRangeFinder"
_REP = "REP 117, Informational Distance Measurements"
_EPSILON = 2.0 * math.pi * float(np.finfo(np.float32).eps)
_SLACK_M = 1e-4

BEAMS = Rule(
    "beam count", "ranges are as many as angle_min, angle_max and angle_increment say",
    "slam_toolbox, which drops all others", f"{_SLAM}::Update, Validate",
)  # fmt: skip
CLOSED = Rule(
    "full circle", "the last beam of a full circle does not repeat the first",
    "slam_toolbox: [0, 360), not [0, 360]", f"{_SLAM}, LaserAssistant::makeLaser",
)  # fmt: skip
STEADY = Rule(
    "same laser", "beam count, angles and limits of range are those of the first scan",
    "slam_toolbox, AMCL: a laser is registered once for each frame_id",
    "slam_toolbox src/slam_toolbox_common.cpp getLaser; nav2_amcl amcl_node.cpp addNewScanner",
)  # fmt: skip
ANGLES = Rule(
    "angles", "finite, angle_increment not 0, at most one turn",
    "laser_geometry, Nav2's obstacle layer", "sensor_msgs/LaserScan.msg; laser_geometry.cpp",
)  # fmt: skip
LIMITS = Rule(
    "limits", "0 <= range_min < range_max, finite", "AMCL, slam_toolbox, Nav2's layers",
    "sensor_msgs/LaserScan.msg; nav2_amcl amcl_node.cpp updateFilter; Karto.h SetRangeThreshold",
)  # fmt: skip
VALUES = Rule(
    "values", "a number is a measurement within the limits; else inf, -inf or NaN",
    "all that follow REP 117 (Nav2's inf_is_valid, costmaps)", _REP,
)  # fmt: skip
TIMES = Rule(
    "beam times", "time_increment and scan_time finite, >= 0, a sweep no longer than scan_time",
    "Nav2's obstacle layer: waits for TF until the last beam",
    "nav2_costmap_2d obstacle_layer.cpp, laser_geometry transformLaserScanToPointCloud",
)  # fmt: skip
INTENSITIES = Rule(
    "intensities", "none, or one for each range", "laser_geometry", "sensor_msgs/LaserScan.msg"
)
CONE = Rule(
    "cone", "field_of_view > 0, radiation_type ultrasound or infrared, 0 <= min < max",
    "Nav2's range sensor layer", "sensor_msgs/Range.msg; nav2_costmap_2d range_sensor_layer.cpp",
)  # fmt: skip

RULES = (BEAMS, CLOSED, STEADY, ANGLES, LIMITS, VALUES, TIMES, INTENSITIES, CONE)


def judge_scans(topic: Topic) -> list[Verdict]:
    """Return the verdicts on a topic of LaserScans."""
    checks = (
        (ANGLES, angles_problem), (BEAMS, beams_problem), (CLOSED, circle_problem),
        (LIMITS, limits_problem), (VALUES, values_problem), (TIMES, times_problem),
        (INTENSITIES, intensities_problem),
    )  # fmt: skip
    verdicts = [judge_each(topic, rule, check) for rule, check in checks]
    return [*verdicts, of_problems(topic, STEADY, steady_problems(topic.messages))]


def judge_ranges(topic: Topic) -> list[Verdict]:
    """Return the verdicts on a topic of Ranges."""
    return [judge_each(topic, CONE, cone_problem), judge_each(topic, VALUES, range_problem)]


def expected_beams(angle_min: float, angle_max: float, increment: float, num: int) -> int:
    """Return how many ranges slam_toolbox expects of a scan that has `num`."""
    span = abs(angle_max - angle_min)
    steps = int(math.floor(span / abs(increment) + 0.5))
    is_full = abs(span - 2.0 * math.pi) < abs(increment) - _EPSILON
    if span > math.radians(350.0) and steps + 1 == num:
        is_full = False
    return steps if is_full else steps + 1


def beams_problem(scan: Any) -> str:
    """Return what is wrong with the number of ranges."""
    if angles_problem(scan):
        return "the angles say no number"
    num = len(scan.ranges)
    wanted = expected_beams(scan.angle_min, scan.angle_max, scan.angle_increment, num)
    return "" if num == wanted else f"{num} ranges, {wanted} expected"


def circle_problem(scan: Any) -> str:
    """Return whether the last beam is the first again."""
    turn = abs(scan.angle_increment) * (len(scan.ranges) - 1)
    if turn < 2.0 * math.pi - 0.5 * abs(scan.angle_increment):
        return ""
    return f"{len(scan.ranges)} beams of {scan.angle_increment:.6f} rad go round {turn:.4f} rad"


def angles_problem(scan: Any) -> str:
    """Return what is wrong with the angles."""
    angles = (scan.angle_min, scan.angle_max, scan.angle_increment)
    if not all(math.isfinite(a) for a in angles) or scan.angle_increment == 0.0:
        return "angle_min {:g}, angle_max {:g}, angle_increment {:g}".format(*angles)
    turn = abs(scan.angle_max - scan.angle_min)
    if turn > 2.0 * math.pi + abs(scan.angle_increment):
        return f"angle_max - angle_min is {turn:.4f} rad"
    if (scan.angle_max - scan.angle_min) * scan.angle_increment < 0.0:
        return "angle_increment has the other sign than angle_max - angle_min"
    return ""


def limits_problem(scan: Any) -> str:
    """Return what is wrong with the limits of range."""
    low, high = float(scan.range_min), float(scan.range_max)
    is_good = math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high
    return "" if is_good else f"range_min {low:g}, range_max {high:g}"


def values_problem(scan: Any) -> str:
    """Return how many ranges are numbers outside of the limits."""
    ranges = np.asarray(scan.ranges, dtype=float)
    number = ranges[np.isfinite(ranges)]
    is_out = (number < scan.range_min - _SLACK_M) | (number > scan.range_max + _SLACK_M)
    if not is_out.any():
        return ""
    limits = f"{scan.range_min:g} to {scan.range_max:g}"
    return f"{int(is_out.sum())} ranges out of {limits} m, such as {number[is_out][0]:g}"


def times_problem(scan: Any) -> str:
    """Return what is wrong with the times of the beams."""
    step, whole = float(scan.time_increment), float(scan.scan_time)
    if not (math.isfinite(step) and math.isfinite(whole) and step >= 0.0 and whole >= 0.0):
        return f"time_increment {step:g}, scan_time {whole:g}"
    sweep = step * max(len(scan.ranges) - 1, 0)
    if whole > 0.0 and sweep > 1.05 * whole:
        return f"a sweep takes {sweep:.4f} s of {whole:.4f} s scan_time"
    return ""


def intensities_problem(scan: Any) -> str:
    """Return what is wrong with the number of intensities."""
    num = len(scan.intensities)
    return "" if num in (0, len(scan.ranges)) else f"{num} for {len(scan.ranges)} ranges"


def steady_problems(scans: list[Any]) -> list[str]:
    """Return for each scan what differs from the first of its frame."""
    first: dict[str, tuple[float, ...]] = {}
    problems = []
    for scan in scans:
        own = (
            len(scan.ranges), scan.angle_min, scan.angle_max, scan.angle_increment,
            scan.range_min, scan.range_max,
        )  # fmt: skip
        wanted = first.setdefault(scan.header.frame_id, own)
        names = ("beams", "angle_min", "angle_max", "angle_increment", "range_min", "range_max")
        differing = [
            f"{name} {b:g} after {a:g}"
            for name, a, b in zip(names, wanted, own, strict=True)
            if not math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-6)
        ]
        problems.append(", ".join(differing))
    return problems


def cone_problem(reading: Any) -> str:
    """Return what is wrong with a Range but its value."""
    if not (math.isfinite(reading.field_of_view) and reading.field_of_view > 0.0):
        return f"field_of_view {reading.field_of_view:g}"
    if reading.radiation_type not in (0, 1):
        return f"radiation_type {reading.radiation_type}"
    low, high = float(reading.min_range), float(reading.max_range)
    is_good = math.isfinite(low) and math.isfinite(high) and low >= 0.0
    return "" if is_good and low <= high else f"min_range {low:g}, max_range {high:g}"


def range_problem(reading: Any) -> str:
    """Return whether a Range is a number outside of its limits."""
    value = float(reading.range)
    low, high = reading.min_range - _SLACK_M, reading.max_range + _SLACK_M
    if not math.isfinite(value) or low <= value <= high:
        return ""
    return f"{value:g} m is out of {reading.min_range:g} to {reading.max_range:g} m"
