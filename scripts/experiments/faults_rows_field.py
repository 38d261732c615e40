"""The faults of a camera, for a robot that has nothing else to drive by."""

from __future__ import annotations

import signal

from experiments.faults_case import Fault, changing
from experiments.faults_changes import (
    Freeze,
    black,
    drop,
    half_size,
    saturated,
    upside_down,
)
from experiments.faults_judge import BRAKE, DRIVE, HALT, OTHER
from experiments.faults_rows_nodes import killing, restarting

_IMAGE = "omni/image_raw"
_LATE_S = 0.5
"""The planner's limit on the silence of what it drives by, here `floor/free_space` (default)."""


def camera_faults() -> list[Fault]:
    """Return the faults of the camera."""
    late = "zero when the newest free space is 0.5 s old"
    blind = "brakes as hard as it may: no floor is seen"
    return [
        Fault(
            name="image-silent", what="no image comes any more", kind=HALT, topic=_IMAGE,
            limit_s=_LATE_S, expected=late, **changing(_IMAGE, lambda: drop),
        ),
        Fault(
            name="image-frozen", what="the same image again and again, with its old stamp",
            kind=HALT, topic=_IMAGE, limit_s=_LATE_S, expected=late,
            is_first_good=True, **changing(_IMAGE, lambda: Freeze(keeps_stamp=True)),
        ),
        Fault(
            name="image-black", what="the image is black", kind=BRAKE, topic=_IMAGE,
            expected=blind, **changing(_IMAGE, lambda: black),
        ),
        Fault(
            name="image-saturated", what="the image is white", kind=BRAKE, topic=_IMAGE,
            expected=blind, **changing(_IMAGE, lambda: saturated),
        ),
        Fault(
            name="image-upside-down", what="the image is upside-down: ahead is behind", kind=OTHER,
            expected="touches nothing", **changing(_IMAGE, lambda: upside_down),
        ),
        Fault(
            name="image-half-size", what="the image has half the size", kind=DRIVE,
            expected="the camera's model is scaled: drives on",
            hold_s=1.5, **changing(_IMAGE, lambda: half_size),
        ),
        Fault(
            name="kill-detector-of-field", what="SIGKILL to floor_detector, then started again",
            kind=HALT, limit_s=_LATE_S, expected=late,
            strike=killing("floor_detector", signal.SIGKILL), mend=restarting("floor_detector"),
        ),
    ]  # fmt: skip
