"""What a step of a simulation gives: each robot's readings, and the truth apart from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge.drive import Velocity
from sim_bridge.people.people import PersonTruth
from sim_bridge.wheels import OdometryState


@dataclass(frozen=True)
class StereoImages:
    """The two images of a pair, RGB uint8."""

    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True)
class GroundTruth:
    """What no sensor knows.

    Attributes:
        pose: `T_world_base`.
        velocity: Of the base over the floor.
        is_touching: True while the robot touches anything but the floor.
    """

    pose: SE2
    velocity: Velocity
    is_touching: bool


@dataclass(frozen=True)
class RobotObservation:
    """What one robot's sensors gave in a step; None where a sensor was not due.

    Attributes:
        scan: A sweep that ends with the step.
        sonar: One reading a sonar of those that fired together, NaN for the others.
        odometry: Dead reckoning at the end of the step.
        refused: Why the command of this step was refused; "" if it was not.
        ground_truth: For judges only; never part of a sensor message.
        omni: Image of the mirror, (height, width, 3), RGB uint8; None too if nobody watches.
        stereo: Images of each pair of cameras that is watched, by its name.
    """

    scan: Scan | None
    odometry: OdometryState | None
    refused: str
    ground_truth: GroundTruth
    sonar: tuple[RangeReading, ...] | None = None
    omni: np.ndarray | None = None
    stereo: Mapping[str, StereoImages] | None = None


@dataclass(frozen=True)
class Observations:
    """All robots at one instant of simulated time.

    Attributes:
        stamp_ns: The instant.
        robots: What each robot's sensors gave, by name.
        ground_truth_people: Where people are; for judges only.
    """

    stamp_ns: int
    robots: dict[str, RobotObservation]
    ground_truth_people: tuple[PersonTruth, ...] = ()
