"""Why the planner must not move."""

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.watchdog import Watchdog

_ANOTHER_CLOCK_S = 1e8  # three years


class InputMissing(Exception):  # noqa: N818, the base says what it means
    """Something is not there, is too old or is not usable: the robot must not move."""


def fixed_frame(frame: str) -> str:
    """Return what is wrong with a goal in a frame of the robot's own."""
    return f"goal: '{frame}' is fixed to the robot; give it in odom or map"


def age_of(node: FloornavNode, what: str, stamp_ns: int, timeout: float) -> float:
    """Return how old a stamp is, s.

    Raises:
        InputMissing: If it is from too long ago, or as far ahead of now.
    """
    age = (node.get_clock().now().nanoseconds - stamp_ns) * 1e-9
    if abs(age) > _ANOTHER_CLOCK_S:
        raise InputMissing(f"{what} stamped by another clock: use_sim_time?")
    if age < -timeout:
        raise InputMissing(f"{what} stamped {-age:.1f} s in the future: two clocks?")
    if age > timeout:
        raise InputMissing(f"{what} its stamp is {age:.1f} s old")
    return max(0.0, age)


def require(watchdog: Watchdog, fault: str) -> None:
    """Go on only with an input that comes and has no fault.

    Raises:
        InputMissing: If it is silent, or there is one.
    """
    if not watchdog.is_fresh:
        raise InputMissing(f"{watchdog.topic}: {watchdog.status().message}")
    if fault:
        raise InputMissing(f"{watchdog.topic}: {fault}")
