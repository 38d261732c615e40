"""A mapping run with loops closed: the recording once for the poses, once more for the grids."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.loop_warm_up import warm_up_loops
from grid_mapper.map_rebuild import MapRebuild
from grid_mapper.map_run import MapRun, run_mapper
from grid_mapper.recordings import Recording
from grid_mapper.session_files import Session, load_session, save_session
from grid_mapper.session_run import TakenUp, all_of, first_scans
from grid_mapper.sweeps import SweepOrder

OnScan = Callable[[MapRun], None]


@dataclass(frozen=True)
class Sessions:
    """Sessions of a run.

    Attributes:
        before: One to go on with; None to begin anew.
        save: File to save this run's in; None saves none.
    """

    before: TakenUp | None = None
    save: Path | None = None


NO_SESSIONS = Sessions()


@dataclass(frozen=True)
class ClosedRun:
    """What a run with loops closed has found.

    Attributes:
        run: Its trajectory is that of the solved graph.
        mapper: Holds the grids.
        closer: Holds the graph.
        sweeps: In which order the beams of a scan were taken.
    """

    run: MapRun
    mapper: LayeredMapper
    closer: LoopCloser
    sweeps: SweepOrder


def run_closing(
    recording: Recording,
    open_again: Callable[[], Recording],
    config: GridMapperConfig,
    max_scans: int | None,
    on_scan: tuple[OnScan, OnScan],
    sessions: Sessions = NO_SESSIONS,
) -> ClosedRun:
    """Localize a recording with loops closed, then make the grids at the poses found.

    Args:
        recording: Its events are taken.
        open_again: Opens the same recording.
        config: Of the mapper.
        max_scans: Stop after so many; None for all.
        on_scan: Called after each scan of the first and of the second time.
        sessions: The one to go on with, and where to save it.

    Raises:
        ValueError: If the graph's solver is not installed.
    """
    warm_up_loops()
    before, mapper = sessions.before, LayeredMapper(config)
    localizer, rest = LoopClosingLocalizer(config), recording
    if before is not None:
        localizer, rest = before.localizer, before.rest(recording)
    found = run_mapper(rest, localizer, max_scans, on_scan[0])
    if before is not None and before.taken is None:
        before = _placed(before, localizer, recording, found)

    def open_all() -> Recording:
        return open_again() if before is None else before.all(open_again())

    saved = None
    if sessions.save is not None and (before is None or not before.is_lost(localizer)):
        saved = _saved(sessions.save, localizer, open_all(), recording)
    started = time.perf_counter()
    localizer.closer.finish()
    finish_ms = 1e3 * (time.perf_counter() - started)
    poses = localizer.known_poses()
    # what was saved may have replaced the session to go on with
    events = open_all() if saved is None else all_of(saved, recording)
    run = run_mapper(events, MapRebuild(mapper, poses), len(poses), on_scan[1])
    run.finish_ms = finish_ms
    run.is_interrupted |= found.is_interrupted
    both = zip(found.scan_ms, run.scan_ms[-len(found.scan_ms) :], strict=False)
    run.scan_ms = [first + second for first, second in both]
    return ClosedRun(run, mapper, localizer.closer, localizer.sweeps)


def _placed(
    before: TakenUp, localizer: LoopClosingLocalizer, recording: Recording, found: MapRun
) -> TakenUp:
    """Leave out the scans of another recording that came before the robot was found."""
    num = localizer.leave_out_unplaced(before.session.num_scans)
    before = replace(before, unplaced=num)
    recording.counts.unplaced = num
    recording.counts.scans += before.session.num_scans
    found.scan_ms = found.scan_ms[num:]
    if before.is_lost(localizer):
        problem = (
            f"the robot was not found in the session {before.session.path.name}: start a recording"
            " near its last or first pose; this one is left out, and no session saved"
        )
        recording.problem = "; ".join(filter(None, (recording.problem, problem)))
    return before


def _saved(
    path: Path, localizer: LoopClosingLocalizer, events: Recording, recording: Recording
) -> Session | None:
    """Save the session; if that is not possible say so, for the map is worth having without."""
    try:
        save_session(path, localizer, first_scans(events, localizer.num_scans))
        return load_session(path, localizer.config)
    except (OSError, ValueError) as error:
        problem = f"the session could not be saved: {error}"
        recording.problem = recording.problem or problem
    return None


def loop_figures(closer: LoopCloser) -> dict[str, Any]:
    """Return what became of the loops, by summary key."""
    return {
        "nodes": len(closer.frames),
        "loops": closer.num_loops,
        "loops_refused": dict(sorted(closer.refused.items())),
    }
