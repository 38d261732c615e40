"""Ultrasonic rangers: cones of rays, echoes by mirror-like surfaces, cross-talk, faults.

A surface met within its critical angle answers: a small one where it is smooth, a wide one where
it is rough or soft. Beyond it sound goes on as from a mirror: what
it meets next may answer on the same way back (a longer echo), a corner sends it home by a third
way, and else nothing comes. The first echo wins. Every sonar hears what all that fire with it
send, so an echo of another one's sound can win too (cross-talk).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from floornav_common.readings import RangeReading
from sim_bridge.rays import BEYOND, Hits
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.surfaces import ROUGH_RAD

Cast = Callable[[np.ndarray, np.ndarray], Hits]
Nearest = Callable[[np.ndarray, np.ndarray, float, float], np.ndarray]
_ROWS = np.arange(-3, 4) / 3.0  # of rays, in shares of half the cone
_OFF_SURFACE = 1e-4
_SAME_PLACE = 1e-9


@dataclass(frozen=True)
class _Sound:
    """Sound on its way home from the last surface it met.

    Attributes:
        senders: Index of the sonar that sent it, shape (M,).
        ways: Length of its way so far, shape (M,), m.
        points: Where it left the last surface, shape (M, 3), m.
        headings: Direction it left in, shape (M, 3); zero = to every side.
    """

    senders: np.ndarray
    ways: np.ndarray
    points: np.ndarray
    headings: np.ndarray


def cone_rays(config: SonarConfig) -> np.ndarray:
    """Return unit vectors that fill the cone along x in rows, to its edge, shape (R, 3)."""
    half, rays = config.opening_rad / 2.0, []
    for up in _ROWS:
        across = np.sqrt(1.0 - up**2)
        count = max(2 * round(across * (config.rays_across - 1) / 2.0) + 1, 1)
        side = half * np.linspace(-across, across, count) if count > 1 else np.zeros(1)
        z = np.full(count, np.sin(up * half))
        flat = np.cos(up * half)
        rays.append(np.column_stack((flat * np.cos(side), flat * np.sin(side), z)))
    return np.vstack(rays)


def first_echoes(
    config: SonarConfig,
    T_world_sonars: np.ndarray,
    critical: np.ndarray,
    cast: Cast,
    nearest: Nearest,
) -> np.ndarray:
    """Return the distance each of the sonars that fire together reports, without its faults.

    Args:
        config: The sonars.
        T_world_sonars: Their poses, shape (F, 4, 4).
        critical: Critical angle of each one's sound on smooth surfaces this time, (F,), rad.
        cast: Gives where rays from and to world points (N, 3) end.
        nearest: Gives unit vectors (K, 3) to the nearest points of things in a cone from its
            place, axis, cosine of half its angle and reach: no thing is too thin to be met.

    Returns:
        Shape (F,), m; inf where nothing is heard.
    """
    rays, places = cone_rays(config), T_world_sonars[:, :3, 3]
    cone = math.cos(config.opening_rad / 2.0), BEYOND * config.range_max_m
    bundles = [
        np.vstack((rays @ T[:3, :3].T, nearest(T[:3, 3], T[:3, 0], *cone))) for T in T_world_sonars
    ]
    senders = np.repeat(np.arange(len(places)), [len(bundle) for bundle in bundles])
    sounds = _follow(config, places[senders], np.vstack(bundles), senders, critical, cast)
    return np.array([_heard(config, k, T_world_sonars, sounds) for k in range(len(places))])


def readings(
    config: SonarConfig, distances: np.ndarray, fired: tuple[int, ...], rng: np.random.Generator
) -> tuple[RangeReading, ...]:
    """Return one reading a sonar, NaN for those that did not fire (REP 117).

    Args:
        config: The sonars.
        distances: Of those that fired, shape (F,), m; inf for no echo.
        fired: Their numbers.
        rng: Source of noise; the same count of numbers is drawn for every firing.
    """
    noise, chance = rng.standard_normal(len(fired)), rng.random(len(fired))
    reached = np.where(np.isfinite(distances), distances, 0.0)
    ranges = distances + np.hypot(config.noise_sd_m, config.noise_sd_share * reached) * noise
    if config.quantum_m > 0.0:
        ranges = np.round(ranges / config.quantum_m) * config.quantum_m
    ranges = np.where(ranges < config.range_min_m, -np.inf, ranges)
    ranges = np.where((ranges > config.range_max_m) | (chance < config.miss_share), np.inf, ranges)
    values = np.full(config.count, np.nan)
    values[list(fired)] = ranges
    limits = (config.opening_rad, config.range_min_m, config.range_max_m)
    return tuple(RangeReading(float(value), *limits) for value in values)


def _follow(
    config: SonarConfig,
    starts: np.ndarray,
    directions: np.ndarray,
    senders: np.ndarray,
    critical: np.ndarray,
    cast: Cast,
) -> _Sound:
    """Follow rays over two surfaces and return all sound that may be heard."""
    reach = BEYOND * config.range_max_m
    met = _meet(starts, directions, np.full(len(starts), reach), senders, cast)
    answers = met.incidence <= critical[met.senders] + met.rough
    first = _Sound(met.senders, met.ways, met.points, np.where(answers[:, None], 0.0, met.mirrored))
    if answers.all():
        return first
    on = ~answers
    lefts = reach - met.ways[on]
    again = _meet(met.points[on], met.mirrored[on], lefts, np.flatnonzero(on), cast)
    before = again.senders  # of the second surface: which first meeting it came from
    senders2 = met.senders[before]
    answers2 = again.incidence <= critical[senders2] + again.rough
    # A surface that answers sends the sound back over the first one; another one only onward.
    ways = met.ways[before] + np.where(answers2, 2.0, 1.0) * again.ways
    points = np.where(answers2[:, None], met.points[before], again.points)
    home = -directions[met.rays[before]]
    headings = np.where(answers2[:, None], home, again.mirrored)
    parts = ((first.senders, senders2), (first.ways, ways), (first.points, points))
    joined = [np.concatenate(pair) for pair in (*parts, (first.headings, headings))]
    return _Sound(*joined)


@dataclass(frozen=True)
class _Meetings:
    """Rays that met a surface: ray, sender, length, point, angle of incidence, mirrored ray.

    `rough` is how much farther from its normal than a smooth one the surface answers.
    """

    rays: np.ndarray
    senders: np.ndarray
    ways: np.ndarray
    points: np.ndarray
    incidence: np.ndarray
    mirrored: np.ndarray
    rough: np.ndarray


def _meet(
    starts: np.ndarray, directions: np.ndarray, reach: np.ndarray, senders: np.ndarray, cast: Cast
) -> _Meetings:
    hits = cast(starts, starts + reach[:, None] * directions)
    rays = np.flatnonzero(np.isfinite(hits.shares))
    along, normals = directions[rays], hits.normals[rays]
    facing = np.einsum("ij,ij->i", along, normals)
    normals = np.where(facing[:, None] > 0.0, -normals, normals)
    incidence = np.arccos(np.clip(np.abs(facing), 0.0, 1.0))
    ways = hits.shares[rays] * reach[rays]
    points = starts[rays] + ways[:, None] * along + _OFF_SURFACE * normals
    mirrored = along + 2.0 * np.abs(facing)[:, None] * normals
    rough = ROUGH_RAD[hits.surfaces[rays]]
    return _Meetings(rays, senders[rays], ways, points, incidence, mirrored, rough)


def _heard(config: SonarConfig, k: int, T_world_sonars: np.ndarray, sounds: _Sound) -> float:
    """Return the distance of the first sound that a sonar hears, m; inf for none."""
    place, axis = T_world_sonars[k, :3, 3], T_world_sonars[k, :3, 0]
    home = place - sounds.points
    last = np.maximum(np.linalg.norm(home, axis=1), _SAME_PLACE)
    lobe = np.cos(config.opening_rad / 2.0) - 1e-6
    own = sounds.senders == k
    hears = np.where(own, lobe, np.cos(config.listening_rad / 2.0))
    is_in_front = home @ -axis >= hears * last
    is_to_every_side = ~sounds.headings.any(axis=1)
    is_aimed = np.einsum("ij,ij->i", sounds.headings, home) >= lobe * last
    distances = (sounds.ways + last) / 2.0
    is_heard = is_in_front & (is_to_every_side | is_aimed)
    is_heard &= distances <= BEYOND * config.range_max_m
    return float(distances[is_heard].min(initial=np.inf))
