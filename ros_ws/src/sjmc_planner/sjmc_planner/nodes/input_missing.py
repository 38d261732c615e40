"""Why the planner must not move."""


class InputMissing(Exception):  # noqa: N818, the base says what it means
    """Something is not there, is too old or is not usable: the robot must not move."""


def fixed_frame(frame: str) -> str:
    """Return what is wrong with a goal in a frame of the robot's own."""
    return f"goal: '{frame}' is fixed to the robot; give it in odom or map"
