"""Where beams cross glass panes, and what a laser range finder measures through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_bridge.glass import (
    Glass,
    optical_delay,
    scatter_probability,
    specular_probability,
    transmittance,
)
from sim_bridge.solids import Solid

_DIRT_CELL = 0.02  # m; dirt is alike within


@dataclass(frozen=True)
class Panes:
    """The glass panes of a world: upright, thin, along the x axis of their solids.

    Attributes:
        starts: One end of each middle line in the world, shape (P, 2), m.
        ends: The other end, shape (P, 2), m.
        spans: Heights of lower and upper edge, shape (P, 2), m.
        glasses: Their materials.
    """

    starts: np.ndarray
    ends: np.ndarray
    spans: np.ndarray
    glasses: tuple[Glass, ...]


@dataclass(frozen=True)
class Crossings:
    """Beams through panes, ordered by beam, then distance.

    Attributes:
        beams: Index of the beam, shape (M,).
        panes: Index of the pane, shape (M,).
        distances: Along the beam to the pane's near face, shape (M,), m.
        places: Along the pane from its start, shape (M,), m.
        cos_incidence: Cosine of the angle between beam and the pane's normal, shape (M,).
    """

    beams: np.ndarray
    panes: np.ndarray
    distances: np.ndarray
    places: np.ndarray
    cos_incidence: np.ndarray


def panes_of(solids: list[Solid]) -> Panes:
    """Return the panes among solids."""
    panes = [solid for solid in solids if solid.glass is not None]
    half = np.array([[solid.size[0] / 2.0, 0.0] for solid in panes]).reshape(-1, 2)
    starts = [solid.pose @ -h[None] for solid, h in zip(panes, half, strict=True)]
    ends = [solid.pose @ h[None] for solid, h in zip(panes, half, strict=True)]
    spans = [[solid.bottom, solid.bottom + solid.size[2]] for solid in panes]
    return Panes(
        np.array(starts).reshape(-1, 2),
        np.array(ends).reshape(-1, 2),
        np.array(spans).reshape(-1, 2),
        tuple(solid.glass for solid in panes if solid.glass is not None),
    )


def crossings(panes: Panes, origin: np.ndarray, directions: np.ndarray, reach: float) -> Crossings:
    """Return where beams meet panes.

    Args:
        panes: The panes.
        origin: Where beams start in the world, shape (3,) for all or (N, 3), m.
        directions: Unit vectors in the world, shape (N, 3).
        reach: Panes farther than this along a beam are left out, m.
    """
    origins, flat = np.atleast_2d(origin), directions[:, :2]
    a, b = panes.starts - origins[:, None, :2], panes.ends - origins[:, None, :2]
    side_a = flat[:, :1] * a[..., 1] - flat[:, 1:2] * a[..., 0]
    side_b = flat[:, :1] * b[..., 1] - flat[:, 1:2] * b[..., 0]
    beams, pane = np.nonzero((side_a > 0.0) != (side_b > 0.0))
    origins = np.broadcast_to(origins, directions.shape)[beams]
    start, along = panes.starts[pane] - origins[:, :2], (panes.ends - panes.starts)[pane]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    normal = np.column_stack((-along[:, 1], along[:, 0]))
    speed = np.einsum("ij,ij->i", flat[beams], normal)
    distance = np.einsum("ij,ij->i", start, normal) / np.where(speed == 0.0, np.nan, speed)
    place = np.einsum("ij,ij->i", distance[:, None] * flat[beams] - start, along)
    thickness = np.array([glass.thickness_m for glass in panes.glasses])[pane]
    height = origins[:, 2] + distance * directions[beams, 2]
    low, high = panes.spans[pane].T
    is_met = (distance > 0.0) & (distance < reach) & (low <= height) & (height <= high)
    cos = np.abs(speed)
    near = np.maximum(distance - thickness / 2.0 / np.maximum(cos, 0.05), 0.0)
    order = np.lexsort((near[is_met], beams[is_met]))
    return Crossings(*(v[is_met][order] for v in (beams, pane, near, place, cos)))


def laser_distances(
    panes: Panes,
    met: Crossings,
    opaque: np.ndarray,
    reach: np.ndarray,
    rng: np.random.Generator,
    dirt_seed: int = 0,
) -> np.ndarray:
    """Return what a laser measures, before its own noise, where beams may cross glass.

    Pane by pane a beam comes straight back (near the normal), is scattered by dirt and measured
    a little behind the pane, or goes on weakened and later than through air. What is behind
    answers if it is near enough for the light that is left: the echo falls with the square of
    the distance and passes every pane twice, so the reach falls with the one-way transmittance.

    Args:
        panes: The panes.
        met: Where beams meet them.
        opaque: Distance to the first thing that is not glass, shape (N,), m; inf for none.
        reach: Distance at which each beam's echo drowns in the open, shape (N,), m.
        rng: Source of what each beam meets.
        dirt_seed: Seed of the dirt that stays in its place.
    """
    ranges = opaque.astype(np.float64)
    left, delay = np.ones(len(opaque)), np.zeros(len(opaque))
    is_open = np.ones(len(opaque), dtype=bool)
    first = np.searchsorted(met.beams, met.beams)
    layer = np.arange(len(met.beams)) - first
    is_before = met.distances < opaque[met.beams]
    for k in range(int(layer.max(initial=-1)) + 1):
        here = np.flatnonzero((layer == k) & is_before & is_open[met.beams])
        beams = met.beams[here]
        returned, share, late = _at_pane(panes, met, here, opaque[beams], rng, dirt_seed)
        is_back = np.isfinite(returned)
        ranges[beams[is_back]] = returned[is_back]
        is_open[beams[is_back]] = False
        left[beams] *= share
        delay[beams] += late
    is_behind = is_open & (left < 1.0)
    is_lost = is_open & (ranges > reach * left)
    return np.where(is_lost, np.inf, np.where(is_behind, ranges + delay, ranges))


def _at_pane(
    panes: Panes,
    met: Crossings,
    here: np.ndarray,
    opaque: np.ndarray,
    rng: np.random.Generator,
    dirt_seed: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return range where a beam comes back (else inf), share of light that goes on, delay."""
    cos, near = met.cos_incidence[here], met.distances[here]
    back, dirt, stays, share, late, depth = (np.empty(len(here)) for _ in range(6))
    for pane in np.unique(met.panes[here]):
        glass, mine = panes.glasses[pane], met.panes[here] == pane
        back[mine] = specular_probability(glass, cos[mine])
        dirt[mine] = scatter_probability(glass, cos[mine])
        stays[mine] = glass.scatter_fixed_share * dirt[mine]
        share[mine] = transmittance(glass, cos[mine])
        late[mine] = optical_delay(glass, cos[mine])
        depth[mine] = glass.scatter_depth_m
    chance = rng.random((2, len(here)))
    depths = rng.standard_exponential(len(here))
    lasting = _lasting(dirt_seed, met.panes[here], np.floor(met.places[here] / _DIRT_CELL))
    is_back, is_fixed = chance[0] < back, lasting[0] < stays
    # So that both kinds together make up the share of dirt.
    is_dirt = is_fixed | (chance[1] < (dirt - stays) / np.maximum(1.0 - stays, 1e-9))
    behind = near + depth * np.where(is_fixed, -np.log1p(-lasting[1]), depths)
    returned = np.where(is_back, near, np.where(is_dirt, np.minimum(behind, opaque), np.inf))
    return returned, share, late


def _lasting(seed: int, panes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return two numbers in [0, 1) for each place of a pane, always the same ones, shape (2, M)."""
    streams = np.array([[2 * seed], [2 * seed + 1]], dtype=np.uint64)
    mixed = _mixed(np.broadcast_to(streams, (2, len(panes))))
    for part in (panes.astype(np.int64), cells.astype(np.int64)):
        mixed = _mixed(mixed + part.astype(np.uint64))
    return np.asarray((mixed >> np.uint64(11)) * 2.0**-53)


def _mixed(keys: np.ndarray) -> np.ndarray:
    """Return 64 bits that look random for each key (the finalizer of splitmix64)."""
    with np.errstate(over="ignore"):
        keys = keys + np.uint64(0x9E3779B97F4A7C15)
        keys = (keys ^ (keys >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        keys = (keys ^ (keys >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(keys ^ (keys >> np.uint64(31)))
