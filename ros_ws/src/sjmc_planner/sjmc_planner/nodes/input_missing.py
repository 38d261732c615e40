"""Why the planner must not move."""


class InputMissing(Exception):  # noqa: N818, the base says what it means
    """Something is not there, is too old or is not usable: the robot must not move."""
