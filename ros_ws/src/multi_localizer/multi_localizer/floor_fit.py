"""Pose from the floor's border as published (floor paper, section 4, steps 4 to 7).

The hull's vertices are fitted to the plan's lines by weighted linearized least squares. Two slips
in print are mended: eq. 20 and 21 hold in the frame turned by psi, so the center's correction is
turned back; and psi is the field's x axis seen from the robot, so the robot's yaw is -psi.
"""

from __future__ import annotations

import math

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.floor_border import convex_hull, row_extremes
from multi_localizer.floor_moments import polygon_moments
from multi_localizer.floor_plan import FloorPlan

NUM_ITERATIONS = 10
MIN_POINTS = 6
STILL = 1e-9


def fit_published(
    mask: np.ndarray, camera: FloorCamera, plan: FloorPlan, num_iterations: int = NUM_ITERATIONS
) -> tuple[SE2, ...]:
    """Return the candidates for the pose of the camera over the plan, best known order none.

    Args:
        mask: Floor region, (H, W), uint8.
        camera: The camera that saw it.
        plan: The floor's border.
        num_iterations: How often steps 5 and 6 are done.

    Raises:
        ValueError: The mask has no region, or the points do not determine a pose.
    """
    hull = convex_hull(row_extremes(mask))
    points, weights = project_border(hull, camera)
    if len(points) < MIN_POINTS:
        raise ValueError(f"at least {MIN_POINTS} points of the border are needed: {len(points)}")
    region, model = polygon_moments(points), polygon_moments(plan.corners)
    psi = region.axis_rad - model.axis_rad
    return tuple(
        fit_lines(points, weights, plan, region.center, angle, num_iterations)
        for angle in (psi, psi + math.pi)
    )


def project_border(pixels: np.ndarray, camera: FloorCamera) -> tuple[np.ndarray, np.ndarray]:
    """Return the points on the floor, (N, 2), m, and their weights (N,) (step 4, eq. 1 to 6).

    w = 1 / (df/dR)^2: how far a pixel outwards reaches on the floor. Pixels that see no floor are
    left out.
    """
    points = camera.floor_points(pixels)
    J = camera.floor_jacobian(pixels)
    ranges = np.hypot(points[:, 0], points[:, 1])
    with np.errstate(invalid="ignore"):
        radial = np.einsum("nij,ni->nj", J, points / ranges[:, None])
        slope2 = (radial**2).sum(axis=1)
    keep = np.isfinite(ranges) & np.isfinite(slope2) & (slope2 > 0.0)
    return points[keep], 1.0 / slope2[keep]


def fit_lines(
    points: np.ndarray,
    weights: np.ndarray,
    plan: FloorPlan,
    center: np.ndarray,
    psi: float,
    num_iterations: int,
) -> SE2:
    """Return the pose that brings points onto the plan's lines (steps 5 to 7).

    Args:
        points: Border seen from the robot, (N, 2), m.
        weights: Of the points, (N,).
        plan: The floor's border.
        center: Of the region, where the plan's center is to begin with, (2,), m.
        psi: The plan's x axis seen from the robot, to begin with.
        num_iterations: How often steps 5 and 6 are done.
    """
    middle = polygon_moments(plan.corners).center
    for _ in range(num_iterations):
        turned = points_turned(points, center, psi) + middle  # eq. 16, 17
        edges = nearest_edges(turned, plan)
        a, b, zeta = solve_step(turned, weights, plan.normals[edges], plan.offsets[edges], middle)
        c, s = math.cos(psi + zeta), math.sin(psi + zeta)
        center = center + np.array((-a * c + b * s, -a * s - b * c))  # eq. 20, 21
        psi = wrap_angle(psi + zeta)  # eq. 22
        if max(abs(a), abs(b), abs(zeta)) < STILL:
            break
    yaw = -psi  # eq. 23
    c, s = math.cos(yaw), math.sin(yaw)
    x = middle[0] - center[0] * c + center[1] * s  # eq. 24
    y = middle[1] - center[0] * s - center[1] * c  # eq. 25
    return SE2(float(x), float(y), yaw)


def points_turned(points: np.ndarray, center: np.ndarray, psi: float) -> np.ndarray:
    """Return points about a center, in axes turned by psi, (N, 2) (eq. 16, 17)."""
    c, s = math.cos(psi), math.sin(psi)
    return np.asarray((points - center) @ np.array([[c, -s], [s, c]]))


def nearest_edges(points: np.ndarray, plan: FloorPlan) -> np.ndarray:
    """Return the edge of the plan that each point (N, 2) is nearest to, (N,)."""
    known = np.array([k for k in range(len(plan.corners)) if k not in plan.unused_edges])
    offset = points[:, None] - plan.corners[known]
    along = np.clip((offset * plan.tangents[known]).sum(axis=-1), 0.0, plan.lengths[known])
    apart = offset - along[..., None] * plan.tangents[known]
    return np.asarray(known[np.hypot(apart[..., 0], apart[..., 1]).argmin(axis=1)])


def solve_step(
    turned: np.ndarray,
    weights: np.ndarray,
    normals: np.ndarray,
    offsets: np.ndarray,
    middle: np.ndarray,
) -> tuple[float, float, float]:
    """Return a, b and zeta of least J (eq. 18, 19), with sin zeta = zeta and cos zeta = 1.

    The turn is about the plan's center: d = n . p + n . (a, b) + zeta n . (p_y, -p_x) - c.

    Raises:
        ValueError: The points do not determine them.
    """
    arm = turned - middle
    by_turn = normals[:, 0] * arm[:, 1] - normals[:, 1] * arm[:, 0]
    A = np.column_stack((normals, by_turn))
    d = offsets - (normals * turned).sum(axis=1)
    normal = A.T @ (weights[:, None] * A)
    if np.linalg.cond(normal) > 1e12:
        raise ValueError("the border's points do not determine a pose")
    a, b, zeta = np.linalg.solve(normal, A.T @ (weights * d))
    return float(a), float(b), float(zeta)
