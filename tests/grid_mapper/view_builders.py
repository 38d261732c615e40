"""Views by hand: what sonars heard, from where."""

import numpy as np

from grid_mapper.echo_judging import NUM_RAYS
from grid_mapper.sonar_views import VIEW

HALF = np.deg2rad(10.0)
ALL_OPEN = 2**NUM_RAYS - 1


def views(*rows):
    """Return views from (x, y, yaw, r) rows; r may be None for a cone free to 5 m."""
    made = np.zeros(len(rows), VIEW)
    for k, (x, y, yaw, r) in enumerate(rows):
        for name, value in (("x", x), ("y", y), ("yaw", yaw), ("half", HALF), ("weight", 1.0)):
            made[k][name] = value
        made[k]["is_echo"], made[k]["r"] = r is not None, 5.0 if r is None else r
        made[k]["open"], made[k]["theta"] = ALL_OPEN if r is not None else 0, yaw
        made[k]["score"], made[k]["stamp_ns"], made[k]["next"] = 10.0, k, k - 1
    return made


def drive_along(xs, y, r, yaw=np.pi / 2.0):
    """Return rows of a drive along x that hears the same range on its left all the way."""
    return [(float(x), y, yaw, r) for x in xs]
