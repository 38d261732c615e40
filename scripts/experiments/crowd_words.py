"""What the columns of the crowd experiment's report mean."""

from __future__ import annotations

from floornav_common.reporting import Section, Table

SHOWN = {
    "runs": "runs", "success": "success", "collisions_caused": "caused",
    "collisions_theirs": "theirs", "collisions_things": "things", "time_s": "time s",
    "path_ratio": "path / line", "min_distance_m": "least m", "time_not_moving_s": "at rest s",
    "longest_stop_s": "longest s", "long_stops_where_all_yield": "over 5 s",
    "heading_changes": "turns", "intimate_s": "< 0.45 m s", "personal_s": "< 1.2 m s",
}  # fmt: skip
BESIDE = {
    "time": "time / VFH+", "runs": "of runs", "time_both": "time / VFH+, both",
    "heading_changes": "turns / VFH+, both", "runs_both": "of runs, both",
}  # fmt: skip
_MEANINGS = {
    "runs": "how many",
    "success": "share: there in 60 s, without a contact that the robot caused",
    "caused": "contacts with people that the robot caused, in all runs",
    "theirs": "contacts with people that they caused, in all runs",
    "things": "contacts with what is no person (walls, furniture), in all runs",
    "time s": "mean time of the runs that got there, s",
    "path / line": "mean way driven over the straight line, of the runs that got there",
    "least m": "mean over all runs of a run's least distance between outline and torso, m",
    "at rest s": "mean time at rest after it set out, all runs, s",
    "longest s": "the longest rest of all runs, s",
    "over 5 s": "runs with a rest of more than 5 s, of those in which everybody yields in the end",
    "turns": "mean number of turns by more than 15 deg, all runs",
    "< 0.45 m s": "mean time with somebody within 0.45 m, all runs, s",
    "< 1.2 m s": "mean time with somebody within 1.2 m, all runs, s",
    "time / VFH+": "sum of the times over that of VFH+ in the same runs; one without success "
    "counts with its 60 s",
    "of runs": "how many those are",
    "time / VFH+, both": "the same, of the runs in which both had success",
    "turns / VFH+, both": "sum of the turns over that of VFH+, of those runs",
    "of runs, both": "how many those are",
}


def glossary() -> Section:
    """Return what the columns and the pictures mean."""
    keys = {column: key for key, column in SHOWN.items()}
    keys |= {column: f"beside_vfh_plus.{key}" for key, column in BESIDE.items()}
    rows = [[column, keys[column], text] for column, text in _MEANINGS.items()]
    return Section("What the columns mean", [Table(["column", "summary.json", "meaning"], rows)])
