"""Whether stated uncertainties are true: normalized estimation errors squared (NEES).

An error e whose covariance C is right has e^T C^-1 e of a chi-square distribution with as many
degrees of freedom as e has parts, here 3 (x, y, yaw): 3 in the mean, 2.37 in the median, and 5 %
lie beyond 7.81. More says that something is surer of itself than it should be, less that it is
less sure (Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001, 5.4.2).
The band is where the mean of so many independent errors lies in 95 of 100 cases. Motions from node
to node count as independent; a loop shares its scans with those of the nodes round it, so so many
count as one; the poses of a drive, which share all that went before, count as one together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import chi2

from floornav_common.report_page import Table
from floornav_common.se2 import SE2, wrap_angle
from grid_mapper.key_frames import Edge
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_config import LoopConfig
from grid_mapper.pose_graph import HELD_SIGMA, deviations_of, load_solver

DOF = 3
SHARE = 0.95
EVERY = 10
"""Every so many nodes the covariance of the solved graph is asked for."""
KINDS = {
    "chain": "motions from node to node",
    "loops": "loops",
    "before": "poses before closing loops",
    "after": "poses of the solved graph",
}
Samples = dict[str, np.ndarray]


def nees(errors: np.ndarray, covs: np.ndarray) -> np.ndarray:
    """Return e^T C^-1 e of errors, shape (N, 3), with covariances, shape (N, 3, 3)."""
    return np.einsum("ni,ni->n", errors, np.linalg.solve(covs, errors[..., None])[..., 0])


def drive_nees(
    closer: LoopCloser, nodes: Sequence[SE2], poses: Sequence[SE2], covs: Sequence[np.ndarray],
    truth: Sequence[SE2],
) -> Samples:  # fmt: skip
    """Return the NEES of all that a drive has found.

    Args:
        closer: The solved graph.
        nodes: True poses of its nodes.
        poses: Of all scans by the front end; the first is the origin of the map.
        covs: Theirs, of (x, y, yaw) in map axes.
        truth: True poses of all scans.
    """
    chain = [edge for edge in closer.edges if not edge.is_loop]
    loops = [edge for edge in closer.edges if edge.is_loop]
    return {
        "chain": deviations_of(chain, nodes) ** 2,
        "loops": deviations_of(loops, nodes) ** 2,
        "before": _front_nees(poses, covs, truth),
        "after": _graph_nees(closer, nodes),
    }


def figures(samples: np.ndarray, num_independent: float) -> dict[str, float | int | None]:
    """Return mean, median, share beyond what 5 % should be, and the band of the mean."""
    if len(samples) == 0:
        return {"num": 0, **dict.fromkeys(("mean", "median", "beyond_share", "low", "high"))}
    low, high = band(num_independent)
    return {
        "num": len(samples), "mean": float(samples.mean()), "median": float(np.median(samples)),
        "beyond_share": float((samples > chi2.ppf(SHARE, DOF)).mean()), "low": low, "high": high,
    }  # fmt: skip


def band(num_independent: float) -> tuple[float, float]:
    """Return where the mean of so many independent NEES lies in 95 of 100 cases."""
    dof = DOF * max(1.0, num_independent)
    low, high = chi2.ppf([(1.0 - SHARE) / 2.0, (1.0 + SHARE) / 2.0], dof) / dof * DOF
    return float(low), float(high)


def drive_figures(drives: Sequence[Samples], loop: LoopConfig) -> dict[str, dict[str, Any]]:
    """Return the figures of each kind over several drives: what `drive_nees` gave, and `loop.*`."""
    found = {}
    for kind in KINDS:
        samples = np.concatenate([drive[kind] for drive in drives]) if drives else np.zeros(0)
        found[kind] = figures(samples, _num_independent(kind, len(samples), len(drives), loop))
    return found


def pooled(drives: Sequence[dict[str, Any]], loop: LoopConfig) -> dict[str, dict[str, Any]]:
    """Return the figures of drives together; the median is the median drive's."""
    found = {}
    for kind in KINDS:
        known = [drive[kind] for drive in drives if drive[kind]["num"]]
        weights = [f["num"] for f in known]
        found[kind] = figures(np.zeros(0), 0)
        if known:
            low, high = band(_num_independent(kind, sum(weights), len(known), loop))
            found[kind] = {
                "num": sum(weights), "median": float(np.median([f["median"] for f in known])),
                "low": low, "high": high,
            } | {
                key: float(np.average([f[key] for f in known], weights=weights))
                for key in ("mean", "beyond_share")
            }  # fmt: skip
    return found


def _num_independent(kind: str, num: int, num_drives: int, loop: LoopConfig) -> float:
    nodes_a_place = 2 * loop.submap_nodes + 1
    return {"chain": num, "loops": num / nodes_a_place}.get(kind, num_drives)


def table(rows: dict[str, dict[str, dict[str, Any]]]) -> Table:
    """Return the table of figures by drive and kind."""
    head = ["", "of", "errors", "NEES: mean", "band of the mean", "median (2.37)", "> 7.81 (5 %)"]
    lines = []
    for name, kinds in rows.items():
        for kind, f in kinds.items():
            cells = ["-"] * 4
            if f["num"]:
                cells = [
                    f"{f['mean']:.2f}", f"{f['low']:.2f} to {f['high']:.2f}",
                    f"{f['median']:.2f}", f"{100 * f['beyond_share']:.1f} %",
                ]  # fmt: skip
            lines.append([name, KINDS[kind], str(f["num"]), *cells])
    return Table(head, lines)


def _front_nees(
    poses: Sequence[SE2], covs: Sequence[np.ndarray], truth: Sequence[SE2]
) -> np.ndarray:
    T_map_true = poses[0] @ truth[0].inverse()
    errors = []
    for pose, true in zip(poses[1:], truth[1:], strict=True):
        there = T_map_true @ true
        errors.append((pose.x - there.x, pose.y - there.y, wrap_angle(pose.yaw - there.yaw)))
    return nees(np.array(errors), np.array(covs[1:]))


def _graph_nees(closer: LoopCloser, nodes: Sequence[SE2]) -> np.ndarray:
    """Return the NEES of nodes, by the graph's own covariance; merged nodes have none."""
    tied = sorted({end for edge in closer.edges for end in (edge.first, edge.second)})
    if len(tied) < 2:
        return np.zeros(0)
    first, asked = tied[0], tied[1:][EVERY - 1 :: EVERY]
    T_map_true = closer.poses[first] @ nodes[first].inverse()
    errors = [closer.poses[k].between(T_map_true @ nodes[k]).as_array() for k in asked]
    if not asked:
        return np.zeros(0)
    return nees(np.array(errors), _covariances(closer.poses, closer.edges, tied, asked))


def _covariances(
    poses: Sequence[SE2], edges: Sequence[Edge], tied: list[int], asked: list[int]
) -> np.ndarray:
    """Return covariances of nodes in their own axes, the first one held, shape (N, 3, 3)."""
    gtsam = load_solver()
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for k in tied:
        values.insert(k, gtsam.Pose2(poses[k].x, poses[k].y, poses[k].yaw))
    held = gtsam.noiseModel.Isotropic.Sigma(3, HELD_SIGMA)
    graph.add(gtsam.PriorFactorPose2(tied[0], values.atPose2(tied[0]), held))
    for edge in edges:
        moved, noise = edge.T_first_second, gtsam.noiseModel.Gaussian.Covariance(edge.cov)
        motion = gtsam.Pose2(moved.x, moved.y, moved.yaw)
        graph.add(gtsam.BetweenFactorPose2(edge.first, edge.second, motion, noise))
    marginals = gtsam.Marginals(graph, values)
    return np.array([marginals.marginalCovariance(k) for k in asked])
