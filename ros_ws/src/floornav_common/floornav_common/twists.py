"""Steady motion in the plane: the exponential of SE(2), its logarithm, and a change of frame.

A twist is the velocity (x, y, yaw) of a frame in its own axes, m/s and rad/s. A frame that keeps it
moves along an arc of a circle. With v = (x, y), w = yaw and R(a) the rotation by a, after a time t

    T(t) = exp(t twist) = (c(t) R(w t / 2) v, w t)                                           (1)
    c(t) = t sin(w t / 2) / (w t / 2)                                                        (2)

as the chord of an arc of angle w t lies half of that angle aside from its beginning, and is shorter
than the arc by (2). The twist that leads to a motion (p, a) within a time t is the inverse of (1),

    w = a / t,   v = R(-a / 2) p / c(t)                                                      (3)

and that of a frame b, fixed to a frame a that moves with the twist (v, w), where T_a_b = (q, b) is

    w_b = w,   v_b = R(-b) (v + w (-q_y, q_x))                                               (4)
"""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2

Twist = tuple[float, float, float]


def steady_offsets(twist: Twist, times: np.ndarray) -> np.ndarray:
    """Return where a frame is after some times, seen from where it was at 0, shape (N, 2), m.

    It is turned by `twist[2] * times` there.

    Args:
        twist: Of the frame, in its own axes.
        times: Shape (N,), s.
    """
    half = 0.5 * twist[2] * times
    chord = times * np.sinc(half / np.pi)  # eq. 2; numpy's sinc(x) is sin(pi x) / (pi x)
    c, s = chord * np.cos(half), chord * np.sin(half)
    return np.column_stack((c * twist[0] - s * twist[1], s * twist[0] + c * twist[1]))  # eq. 1


def twist_between(T_a_b: SE2, dt: float) -> Twist:
    """Return the steady twist that leads from a to b within a time, eq. 3.

    Args:
        T_a_b: The motion; a turn of pi or more is taken for the shorter one.
        dt: The time, s.

    Raises:
        ValueError: If dt is not > 0.
    """
    if not dt > 0.0:
        raise ValueError(f"dt must be > 0, got {dt}")
    half = 0.5 * T_a_b.yaw
    chord = dt * float(np.sinc(half / np.pi))
    c, s = float(np.cos(half)) / chord, float(np.sin(half)) / chord
    return c * T_a_b.x + s * T_a_b.y, -s * T_a_b.x + c * T_a_b.y, T_a_b.yaw / dt


def twist_of_mounted(twist: Twist, T_a_b: SE2) -> Twist:
    """Return the twist of a frame b that is fixed to a moving frame a, in b's axes, eq. 4."""
    x, y = twist[0] - twist[2] * T_a_b.y, twist[1] + twist[2] * T_a_b.x
    c, s = float(np.cos(T_a_b.yaw)), float(np.sin(T_a_b.yaw))
    return c * x + s * y, -s * x + c * y, twist[2]
