"""Configuration as frozen dataclasses: the one place where a default, its unit and range stand.

A field made with `param` carries what a ROS parameter descriptor, a YAML check and the generated
reference need. `validate` enforces the ranges; call it in `__post_init__`.
"""

from __future__ import annotations

import math
from dataclasses import Field, field, fields
from typing import Any


def param(
    default: Any,
    doc: str,
    *,
    unit: str = "",
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
    choices: tuple[str, ...] = (),
    read_only: bool = False,
) -> Any:
    """Declare one configuration value.

    Args:
        default: Its default; bool, int, float, str or a tuple of one of them.
        doc: One sentence for the user.
        unit: SI unit, or "" for a plain number.
        ge: Smallest value allowed (closed bound).
        gt: Bound below that is itself not allowed (open bound).
        le: Greatest value allowed (closed bound).
        lt: Bound above that is itself not allowed (open bound).
        choices: The strings allowed; empty for any.
        read_only: True where a change needs a restart.

    Returns:
        A `dataclasses.field`.
    """
    metadata = {
        "doc": doc, "unit": unit, "ge": ge, "gt": gt, "le": le, "lt": lt,
        "choices": choices, "read_only": read_only,
    }  # fmt: skip
    return field(default=default, metadata=metadata)


def validate(config: Any) -> None:
    """Check every field of a configuration dataclass against its declaration.

    Raises:
        ValueError: If a value is outside its range, not finite, or not among its choices.
    """
    for f in fields(config):
        values = getattr(config, f.name)
        for value in values if isinstance(values, tuple) else (values,):
            _check(f, value)


def range_text(f: Field[Any]) -> str:
    """Return the range of a field in words, such as `> 0, <= 1`; "" if unbounded."""
    signs = (("ge", ">="), ("gt", ">"), ("le", "<="), ("lt", "<"))
    bounds = [f"{s} {f.metadata[k]:g}" for k, s in signs if f.metadata.get(k) is not None]
    if f.metadata.get("choices"):
        bounds.append("one of " + ", ".join(f.metadata["choices"]))
    return ", ".join(bounds)


def _check(f: Field[Any], value: Any) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{f.name} must be finite, got {value}")
    m = f.metadata
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    too_low = is_number and (
        (m.get("ge") is not None and value < m["ge"])
        or (m.get("gt") is not None and value <= m["gt"])
    )
    too_high = is_number and (
        (m.get("le") is not None and value > m["le"])
        or (m.get("lt") is not None and value >= m["lt"])
    )
    unknown = bool(m.get("choices")) and value not in m["choices"]
    if too_low or too_high or unknown:
        raise ValueError(f"{f.name} must be {range_text(f)}, got {value!r}")
