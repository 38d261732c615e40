"""How `relocalization` counts: tries of the search, outcomes of drives, and their tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.relocalization_robot import Outcome

HEAD = [
    "", "places", "found", "false claims", "time s", "p90 s", "way m", "p90 m", "error m",
    "seconds until found", "p90",
]  # fmt: skip
SENT_HEAD = [
    "", "places", "found", "false claims", "seconds until found", "p90", "said lost",
    "seconds until said", "p90", "believed a wrong pose before", "longest, s",
]  # fmt: skip


@dataclass(frozen=True)
class Try:
    """What a method said of a place.

    Attributes:
        error_m: Of the pose claimed; None without a claim.
        is_found: Whether that is near enough to the true one.
        time_s: Computing time of all looks.
        way_m: Driven before.
        drive_s: Time that this took.
        looks: Scans looked at.
    """

    error_m: float | None
    is_found: bool
    time_s: float
    way_m: float
    drive_s: float
    looks: int

    @property
    def is_false(self) -> bool:
        """Whether another was claimed."""
        return self.error_m is not None and not self.is_found


def quantile(values: list[float], share: float) -> float | None:
    """Return a quantile; None of nothing."""
    return float(np.quantile(values, share)) if values else None


def sent_figures(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of `rough` or `carried`; times are of the robots that were found."""
    found = [o.found_s + o.search_s for o in outcomes if o.found_s is not None]
    lost = [o.lost_s for o in outcomes if o.lost_s is not None]
    return {
        "places": len(outcomes), "found_share": len(found) / max(1, len(outcomes)),
        "false_claims": sum(o.is_false for o in outcomes),
        "until_found_s": quantile(found, 0.5), "until_found_s_p90": quantile(found, 0.9),
        "said_lost": len(lost), "until_lost_s": quantile(lost, 0.5),
        "until_lost_s_p90": quantile(lost, 0.9),
        "believed_wrong": sum(o.wrong_s > 0.0 for o in outcomes),
        "believed_wrong_s_max": max((o.wrong_s for o in outcomes), default=0.0),
        "search_cpu_s": quantile([o.search_s for o in outcomes], 0.5),
    }  # fmt: skip


def try_figures(tries: list[Try]) -> dict[str, Any]:
    """Return the figures of a method; medians are of the places found."""
    found = [t for t in tries if t.is_found]
    until = [t.drive_s + t.time_s for t in found]
    return {
        "places": len(tries),
        "found_share": len(found) / max(1, len(tries)),
        "false_claims": sum(t.is_false for t in tries),
        "time_s": quantile([t.time_s for t in found], 0.5),
        "time_s_p90": quantile([t.time_s for t in found], 0.9),
        "way_m": quantile([t.way_m for t in found], 0.5),
        "way_m_p90": quantile([t.way_m for t in found], 0.9),
        "error_m": quantile([t.error_m for t in found if t.error_m is not None], 0.5),
        "looks": quantile([float(t.looks) for t in found], 0.5),
        "until_found_s": quantile(until, 0.5),
        "until_found_s_p90": quantile(until, 0.9),
    }


def try_cells(f: dict[str, Any]) -> list[str]:
    """Return a row below `HEAD`."""
    keys = ("time_s", "time_s_p90", "way_m", "way_m_p90", "error_m")
    rest = [_number(f[key], 3) for key in keys]
    rest += [_number(f[key], 1) for key in ("until_found_s", "until_found_s_p90")]
    return [str(f["places"]), f"{100 * f['found_share']:.1f} %", str(f["false_claims"]), *rest]


def sent_cells(f: dict[str, Any]) -> list[str]:
    """Return a row below `SENT_HEAD`."""
    until = [_number(f[key], 1) for key in ("until_found_s", "until_found_s_p90")]
    lost = [_number(f[key], 1) for key in ("until_lost_s", "until_lost_s_p90")]
    wrong = [str(f["believed_wrong"]), _number(f["believed_wrong_s_max"], 1)]
    head = [str(f["places"]), f"{100 * f['found_share']:.1f} %", str(f["false_claims"])]
    return [*head, *until, str(f["said_lost"]), *lost, *wrong]


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
