"""What was to be reached in the thesis's experiments, and whether `sjmc` did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

NEAREST_M = 1.3  # straight runs without a contact are aimed at from this distance on
ROOM_M = 0.2
_SHARE, _RATIO = 0.9, 1.2


def aims(values: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row an aim that was measured: `aim`, `found` in words, `is_met`.

    Args:
        values: `fig5_5`, `stable` and `static` as `summary.json` holds them.
    """
    return [*_crossing(values["fig5_5"]), *_stable(values["stable"]), *_static(values["static"])]


def _crossing(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    own = [r for r in rows if r["method"] == "sjmc" and r["distance_m"] >= NEAREST_M]
    if not own:
        return []
    where = f"past who crosses, from {NEAREST_M:g} m on"
    touched = [f"{r['contacts']} of {r['runs']} at {r['distance_m']:g} m "
               f"({r['contacts_by_robot']} by the robot)"
               for r in own if r["contacts"]]  # fmt: skip
    near = [f"{r['clear']:.0%} at {r['distance_m']:g} m" for r in own if r["clear"] < 1.0]
    least = min(r["straight"] for r in own)
    return [
        _row(f"{where}: no contact", ", ".join(touched) or "none", is_met=not touched),
        _row(f"{where}: {ROOM_M:g} m of room in every run", ", ".join(near) or "all",
             is_met=not near),
        _row(f"{where}: straight in {_SHARE:.0%} at each distance", f"{least:.0%} at worst",
             is_met=least >= _SHARE),
    ]  # fmt: skip


def _stable(stable: Mapping[str, Any]) -> list[dict[str, Any]]:
    found = []
    for who, by_method in (("stands", stable["methods"]), ("comes", stable["oncoming"])):
        yields, never = by_method["sjmc"]["yielding"], by_method["sjmc"]["unyielding"]
        if yields["runs"]:
            share = yields["success"]
            text = f"who {who} and yields: straight on, untouched, in {_SHARE:.0%}"
            found.append(_row(text, f"{share:.0%}", is_met=share >= _SHARE))
        if never["runs"]:
            share = never["success"]
            text = f"who {who} and never yields: past, untouched, in every run"
            found.append(_row(text, f"{share:.0%}", is_met=share == 1.0))
    return found


def _static(static: Mapping[str, Any]) -> list[dict[str, Any]]:
    own = [s for s in static.values() if s["ratio"] is not None]
    if not own:
        return []
    ratio = max(s["ratio"] for s in own)
    peer = max(s["time_s"]["vfh_plus"] / s["vfh_plus_allowed_s"] for s in own)
    return [
        _row(f"past a thing: time over that of VFH+ at most {_RATIO:g}", f"{ratio:.2f}",
             is_met=ratio <= _RATIO),
        _row("VFH+ past a thing: at most 1.1 (path / speed + 1 s)", f"{peer:.2f} of that",
             is_met=peer <= 1.0),
    ]  # fmt: skip


def _row(aim: str, found: str, *, is_met: bool) -> dict[str, Any]:
    return {"aim": aim, "found": found, "is_met": is_met}
