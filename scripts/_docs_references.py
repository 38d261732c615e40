"""What two recordings can be held against, neither of them surveyed.

A bag in which a localizer ran: its map->odom with the odometry says where it believed to be. A bag
that comes with a map of its floor, which its authors made with other tools: how far our walls are
from that map's, laid on it where they fit best.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt

from _docs_tables import row_of
from _docs_trajectories import odometry
from experiments.slam_measures import tolerant_iou
from floornav_common.grid import UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.config import GridMapperConfig
from grid_mapper.global_search import GlobalSearch
from grid_mapper.map_files import load_map
from grid_mapper.map_surfaces import is_occupied, surfaces_of
from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_frames import plain
from grid_mapper.recordings.bag_messages import transforms_from
from grid_mapper.recordings.bag_survey import tf_topics
from grid_mapper.recordings.pose_track import PoseTrack
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.trajectory_metrics import Trajectory, load_tum, trajectory_errors

MAP_FRAME, ODOM_FRAME = "map", "odom"
NUM_PEAKS, PEAK_SHARE = 8, 0.7
START_COV = np.diag([0.1, 0.1, 0.05]) ** 2
NUM_MATCHES = 10
NEAR_M = 0.1
LOCALIZER_HEAD = (
    "| recording: poses | compared | distance to the localizer's poses, m RMS |"
    " from scan to scan, m RMS |\n" + "| --- " * 4 + "|\n"
)
PLAN_HEAD = (
    "| recording | cells of wall | distance to the plan's walls, m: median | p90 |"
    " within 0.1 m | IoU |\n" + "| --- " * 6 + "|\n"
)


@dataclass(frozen=True)
class PlanErrors:
    """How a map lies on the plan of its floor.

    Attributes:
        num_cells: Occupied cells of the map.
        median_m: Of their distances to the nearest wall of the plan.
        p90_m: Nine tenths of them are nearer than this.
        near_share: Share that is within 0.1 m.
        iou: Intersection over union of walls where the map knows the floor, a cell beside counted
            as the same.
    """

    num_cells: int
    median_m: float
    p90_m: float
    near_share: float
    iou: float


def localizer_rows(name: str, recording: Path, out: Path) -> dict[str, str]:
    """Return the rows of a bag in which a localizer ran: our poses and odometry.

    Args:
        name: Of the recording.
        recording: The bag.
        out: Folder that it was mapped to.
    """
    reference, rows = localizer_poses(recording), {}
    poses = {"grid_mapper": load_tum(out / "trajectory.tum"), "raw odometry": odometry(recording)}
    for what, trajectory in poses.items():
        errors, key = trajectory_errors(trajectory, reference), f"{name}: {what}"
        rows[key] = row_of([key, errors.num_compared, f"{errors.ate:.3f}", f"{errors.rpe:.4f}"])
    return rows


def plan_row(name: str, plan: Path, out: Path) -> str:
    """Return the row of a recording that comes with a map of its floor.

    Args:
        name: Of the recording.
        plan: File of that map.
        out: Folder that the recording was mapped to.
    """
    errors = plan_errors(load_map(out / "map.yaml"), load_map(plan))
    return row_of([
        name, errors.num_cells, f"{errors.median_m:.3f}", f"{errors.p90_m:.3f}",
        f"{100 * errors.near_share:.0f} %", f"{errors.iou:.3f}",
    ])  # fmt: skip


def localizer_poses(path: Path) -> Trajectory:
    """Return where the localizer that ran in a bag believed the robot to be, at every scan."""
    track = PoseTrack()
    with Bag(path) as bag:
        for message in bag.messages(tf_topics(bag)):
            for parent, child, stamp_ns, *pose in transforms_from(bag.deserialize(message)):
                if (plain(parent), plain(child)) == (MAP_FRAME, ODOM_FRAME):
                    track.add(stamp_ns, Transform3.from_parts(*pose).to_se2())
    found = ((stamp_ns, track.at(stamp_ns), odom) for stamp_ns, odom in odometry(path))
    return [(ns, T_map_odom @ odom) for ns, T_map_odom, odom in found if T_map_odom is not None]


def plan_errors(ours: OccupancyMap, plan: OccupancyMap) -> PlanErrors:
    """Lay a map on the plan of its floor where it fits best, and say how well it fits."""
    T_plan_ours = laid_on(ours, plan)
    walls = is_occupied(ours)
    to_wall = distance_transform_edt(~is_occupied(plan)) * plan.resolution
    points = T_plan_ours @ ours.to_points(np.argwhere(walls))
    distances = _at(to_wall, plan, points)
    there = plan.to_points(np.argwhere(is_occupied(plan)))
    known = binary_dilation(ours.cells != UNKNOWN, np.ones((3, 3), bool))
    drawn = _mask(ours, T_plan_ours.inverse() @ there) & known
    return PlanErrors(
        num_cells=len(points), median_m=float(np.median(distances)),
        p90_m=float(np.quantile(distances, 0.9)), near_share=float((distances <= NEAR_M).mean()),
        iou=tolerant_iou(walls & known, drawn),
    )  # fmt: skip


def laid_on(ours: OccupancyMap, plan: OccupancyMap) -> SE2:
    """Return where the frame of a map lies in a plan's, by what fits best anywhere."""
    surfaces, search = surfaces_of(ours), GlobalSearch(plan)
    matcher = ScanMatcher(GridMapperConfig().matcher)
    matcher.insert(search.surfaces, SE2.identity())
    fits = []
    for peak in search.find(surfaces.points, PEAK_SHARE, NUM_PEAKS):
        pose = peak.pose
        for _ in range(NUM_MATCHES):
            fit = matcher.match(surfaces, pose, START_COV)
            pose = fit.T_map_base
        fits.append(fit)
    if not fits:
        raise ValueError("the map fits its floor's plan nowhere")
    return max(fits, key=lambda fit: fit.overlap * fit.agreement).T_map_base


def _at(values: np.ndarray, grid: OccupancyMap, points: np.ndarray) -> np.ndarray:
    """Return the value of the cell of every point; beside the grid that of its edge."""
    rows, cols = grid.to_cells(points).T
    height, width = grid.cells.shape
    return np.asarray(values[np.clip(rows, 0, height - 1), np.clip(cols, 0, width - 1)])


def _mask(grid: OccupancyMap, points: np.ndarray) -> np.ndarray:
    """Return the cells of a grid in which a point lies, shape (H, W)."""
    rows, cols = grid.to_cells(points).T
    height, width = grid.cells.shape
    inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
    mask = np.zeros((height, width), bool)
    mask[rows[inside], cols[inside]] = True
    return mask
