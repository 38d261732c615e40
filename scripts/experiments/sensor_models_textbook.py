"""What simulated sensors ought to do, written from textbooks and not from the simulator.

Nothing here comes from `sim_bridge`: an error there would else judge itself. Angles of incidence
are in rad.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import norm


def reflectance_of_a_face(angle: np.ndarray, index: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Fresnel's reflectances across and along the plane of incidence, by sines and tangents.

    Hecht, Optics, 4.6: R_s = sin^2(i - t) / sin^2(i + t), R_p = tan^2(i - t) / tan^2(i + t).
    """
    i = np.maximum(np.asarray(angle, dtype=float), 1e-6)  # at 0 both are 0 / 0
    t = np.arcsin(np.sin(i) / index)
    return (
        np.sin(i - t) ** 2 / np.sin(i + t) ** 2,
        np.tan(i - t) ** 2 / np.tan(i + t) ** 2,
    )


def light_through_a_pane(angle: np.ndarray, index: float, at_normal: float) -> np.ndarray:
    """Return the share of unpolarized light that crosses a plane plate.

    All reflections between the faces are added without interference (Born and Wolf, 7.6, with
    the fringes averaged out): (1 - R) / (1 + R) for either polarization. What the glass takes up
    goes with the way inside (Lambert-Beer), and is set by the share `at_normal`.
    """

    def clear(i: np.ndarray) -> np.ndarray:
        faces = reflectance_of_a_face(i, index)
        return np.asarray(sum((1.0 - R) / (1.0 + R) for R in faces) / 2.0)

    inside = np.arcsin(np.sin(angle) / index)
    taken_up = at_normal / clear(np.zeros(1))[0]
    return np.asarray(clear(np.asarray(angle)) * taken_up ** (1.0 / np.cos(inside)))


def delay_of_a_pane(angle: np.ndarray, index: float, thickness: float) -> np.ndarray:
    """Return how much longer light seems to go through a plane plate than through air, m.

    Born and Wolf, 7.5: d (sqrt(n^2 - sin^2 i) - cos i); the beam's sideways offset is left out.
    """
    return np.asarray(thickness * (np.sqrt(index**2 - np.sin(angle) ** 2) - np.cos(angle)))


def mirror_share(angle: np.ndarray, at_normal: float, half_width: float) -> np.ndarray:
    """Return the share of beams that a pane sends straight back: a bell, half at the half width."""
    return np.asarray(at_normal * np.exp(-np.log(2.0) * (np.asarray(angle) / half_width) ** 2))


def dirt_share(angle: np.ndarray, at_normal: float) -> np.ndarray:
    """Return the share of beams that meet dirt: independent specks, as the way in it is longer."""
    return np.asarray(1.0 - np.exp(np.log(1.0 - at_normal) / np.cos(angle)))


def lost_share(
    distance: np.ndarray, angle: np.ndarray, reach: float, share_of_light: np.ndarray, sd: float
) -> np.ndarray:
    """Return the share of echoes too weak to be heard (radar equation, wide rough target).

    The power that comes back from a Lambertian wall is as cos i T^2 / r^2; `reach` is where it is
    just enough squarely through air. `sd` is the deviation of the logarithm of the reach.
    """
    power = np.cos(angle) * share_of_light**2 * (reach / distance) ** 2
    return np.asarray(norm.cdf(-0.5 * np.log(power) / sd))


def answered_share(
    beyond_cone: np.ndarray, critical: float, critical_sd: float, miss_share: float
) -> np.ndarray:
    """Return the share of firings at a smooth wall that are answered.

    A wall answers if its normal is within the critical angle, drawn anew each firing, of the
    nearest ray of the cone, `beyond_cone` from the cone's edge.
    """
    return np.asarray((1.0 - miss_share) * norm.cdf((critical - beyond_cone) / critical_sd))


def cross_talk_range(
    sender: np.ndarray, axis: float, receiver: np.ndarray, facing: float, wall_x: float,
    half_cone: float, critical: float, half_listening: float,
) -> float:  # fmt: skip
    """Return what a sonar reads that hears only another one's echo from a wall x = wall_x, m.

    The lit part of the wall (in the sender's cone, met within the critical angle) shines to every
    side; the receiver hears what comes from within its listening angle. Half of the shortest way
    there and back; inf if it hears none.

    Args:
        sender: Where the other one is, (2,), m.
        axis: Bearing of its axis, rad.
        receiver: Where this one is, (2,), m.
        facing: Bearing of its axis, rad.
        wall_x: Where the wall is, m.
        half_cone: Half the sender's opening, rad.
        critical: Critical angle, rad.
        half_listening: Half the receiver's listening angle, rad.
    """
    bearings = axis + np.linspace(-half_cone, half_cone, 4001)
    bearings = bearings[np.abs(bearings) <= critical]
    spots = np.column_stack((np.full(len(bearings), wall_x),
                             sender[1] + (wall_x - sender[0]) * np.tan(bearings)))  # fmt: skip
    off = spots - receiver
    is_heard = np.abs(np.arctan2(off[:, 1], off[:, 0]) - facing) <= half_listening
    ways = np.hypot(*(spots - sender).T) + np.hypot(*off.T)
    return float(ways[is_heard].min(initial=np.inf) / 2.0)
