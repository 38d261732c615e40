"""Tables of localization by landmarks."""

from __future__ import annotations

import math
from typing import Any

from floornav_common.reporting import Table


def picture_table(rows: list[dict[str, Any]]) -> Table:
    """Return what the methods did with pictures as a table."""
    header = [
        "method", "poses", "refused", "mean |x| mm", "|y| mm", "|yaw| deg", "paper x", "y", "yaw",
        "rms x mm", "y mm", "yaw deg", "NEES", "95 % band",
    ]  # fmt: skip
    return Table(header, [
        [
            r["method"], r["poses"], r["refused"], *_three(r, "mean"), *_three(r, "paper"),
            *_three(r, "rms"), _round(r["nees"], 2), _band(r),
        ]
        for r in rows
    ])  # fmt: skip


def noise_table(rows: list[dict[str, Any]]) -> Table:
    """Return what they did with bearings of known noise as a table."""
    header = [
        "noise deg", "method", "poses", "refused", "mean |x| mm", "|y| mm", "|yaw| deg",
        "rms / bound", "NEES", "95 % band",
    ]  # fmt: skip
    return Table(header, [
        [
            r["noise_deg"], r["method"], r["poses"], r["refused"], *_three(r, "mean"),
            _round(r["crlb_ratio"], 2), _round(r["nees"], 2), _band(r),
        ]
        for r in rows
    ])  # fmt: skip


def _three(row: dict[str, Any], what: str) -> list[float | None]:
    names = (f"{what}_x_mm", f"{what}_y_mm", f"{what}_theta_deg")
    digits = (0, 0, 2)
    return [_round(row[n], d) for n, d in zip(names, digits, strict=True)]


def _round(value: float | None, digits: int) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, digits)


def _band(row: dict[str, Any]) -> str:
    return "-" if row["nees_band"] is None else "{:.2f} to {:.2f}".format(*row["nees_band"])
