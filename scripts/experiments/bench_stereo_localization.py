"""Time of a search of the whole map and of a tracking step, with two stereo pairs.

Map: the stereo room, 514 x 514 x 18 voxels. Views come from our matcher and cycle through places of
the room (search) or go to and fro on a drive with odometry (tracking); matching is not in the time
(job `stereo`). Peer: the published search, which has to be done for every view. Floor: one view of
320 x 8 pixels a pair drawn from the map, which holding any pose against the views needs.
To reach: 2 s a search, 100 ms a step, on 2 cores.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from experiments.stereo_drive import PERIOD_S, drive_poses, odometry_steps
from experiments.stereo_places import Observer
from experiments.stereo_views import WORLD, StereoRoom
from experiments.stereo_world_map import map_of_world
from experiments.timing import Case, median_and_p99, take_turns
from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState
from multi_localizer.stereo_view import VIEW_COLUMNS, VIEW_ROWS, StereoView
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import VoxelScene

NUM_PLACES, NUM_STEPS, NUM_SEARCHES = 5, 12, 10
PEER = "published search"
TO_REACH_MS = {"search": 2000.0, "tracking": 100.0}
Views = list[StereoView | None]


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for the search and for tracking, with one thread and with two."""
    say("stereo_localization: the map and what is seen")
    voxels, room = map_of_world(WORLD), StereoRoom(seed)
    observer, rng = Observer(room, ("ours",)), np.random.default_rng(seed)
    places = [observer.look(room.standing_pose(rng), k).views["ours"] for k in range(NUM_PLACES)]
    poses = drive_poses(NUM_STEPS * 0.04)
    drive = [observer.look(pose, 100 + k).views["ours"] for k, pose in enumerate(poses)]
    motions = odometry_steps(poses, rng)
    cases = []
    for num_threads in (1, 2):
        say(f"stereo_localization: {num_threads} thread{'s'[: num_threads - 1]}")
        cases += _cases(voxels, observer, places, drive, motions, num_threads)
    return cases


def _cases(
    voxels: VoxelMap, observer: Observer, places: Sequence[Views], drive: Sequence[Views],
    motions: Sequence[SE2], num_threads: int,
) -> list[Case]:  # fmt: skip
    def localizer(method: str) -> StereoLocalizer:
        config = StereoLocalizerConfig(method=method)
        return StereoLocalizer(voxels, observer.cameras, config, num_threads)

    scene, pose = VoxelScene(voxels, num_threads), np.array([[2.2, 2.4, 0.3]])
    size = VIEW_COLUMNS, VIEW_ROWS
    ours, published = localizer("ours"), localizer("published")
    shown, again = itertools.cycle(places), itertools.cycle(places)
    ms = take_turns(
        {
            "search": lambda: ours.locate(next(shown)),
            "peer": lambda: published.locate(next(again)),
            "floor": lambda: [scene.render(pose, c, size) for c in observer.cameras],
        },
        NUM_SEARCHES,
    )
    tracked = _tracking(localizer("ours"), drive, motions)
    ms["tracking"] = take_turns({"tracking": tracked}, 6 * NUM_STEPS)["tracking"]
    peer, floor = (float(np.median(ms[name])) for name in ("peer", "floor"))
    cases = []
    for name in ("search", "tracking"):
        extra = {"to_reach_ms": TO_REACH_MS[name], "threads": num_threads}
        case = f"{name}_{num_threads}_thread{'s'[: num_threads - 1]}"
        cases.append(Case(case, *median_and_p99(ms[name]), PEER, peer, floor, extra))
    return cases


def _tracking(
    localizer: StereoLocalizer, drive: Sequence[Views], motions: Sequence[SE2]
) -> Callable[[], object]:
    """Return a call that goes one step on along the drive, and back from its end."""
    localizer.track(drive[0], SE2.identity(), 0.0)
    there = [(drive[k + 1], motion) for k, motion in enumerate(motions)]
    back = [(drive[k], motion.inverse()) for k, motion in enumerate(motions)]
    steps = itertools.cycle([*there, *reversed(back)])

    def step() -> object:
        views, motion = next(steps)
        found = localizer.track(views, motion, PERIOD_S)
        if found.state is StereoState.LOST or not math.isfinite(found.hypotheses[0].score):
            raise RuntimeError(f"lost on the way: {found.reason}")
        return found

    return step
