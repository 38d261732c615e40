"""Sessions of the live mapper: what was kept as events of a session, and back.

What was kept has poses by the front end, whose frame drifts and never jumps: in a session that
frame is the odometry. The front end begins anew behind the nodes, with a jump, as it does for
another recording.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from floornav_common.se2 import SE2
from grid_mapper.kept_archive import KeptArchive
from grid_mapper.kept_events import Kept, KeptReading, KeptScan
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.recordings.events import Event, RangeEvent, ScanEvent
from grid_mapper.session_files import save_session
from grid_mapper.sweeps import Sweep, sweep_of, with_sweep

OLD = -1
"""Number of events that were kept before."""


def save_live(path: Path, closer: LoopCloser, archive: KeptArchive) -> None:
    """Save a session of the live mapper, whole or not at all.

    Args:
        path: The file; one that is there is replaced.
        closer: The graph.
        archive: What maps are made from.

    Raises:
        ValueError: Nothing was mapped yet.
        OSError: It cannot be written.
    """
    if not closer.frames:
        raise ValueError("there is nothing to save: not one scan was mapped")
    scans = (event for event in archive.from_index(0, len(archive)) if isinstance(event, KeptScan))
    followed = ((e.T_local_base, e.node, sweep_of(e.scan)) for e in scans)
    localizer = LoopClosingLocalizer.behind(closer, followed)
    save_session(path, localizer, map(_event, archive.from_index(0, len(archive))))


def kept_of(
    events: Iterable[Event], followed: Sequence[tuple[SE2, int, Sweep | None] | None]
) -> Iterator[Kept]:
    """Yield what to keep of the events of a session.

    Readings lie where odometry leads from the scan before them; those behind a scan that was not
    trusted are left out, as that is.

    Args:
        events: Scans and readings in order.
        followed: Of each scan its pose by the front end, the newest node and the sweep; None where
            it was not trusted.
    """
    places, here, odom = iter(followed), None, None
    for event in events:
        if isinstance(event, ScanEvent):
            here, odom = next(places), event.T_odom_base
            if here is not None:
                yield _kept_scan(event, *here)
        elif here is not None:
            now = event.T_odom_base
            moved = SE2.identity() if odom is None or now is None else odom.between(now)
            pose, node = here[0] @ moved, here[1]
            place = (event.T_base_sonar, pose, node, event.frame)
            yield KeptReading(OLD, event.stamp_ns, event.reading, *place)


def _kept_scan(event: ScanEvent, T_local_base: SE2, node: int, sweep: Sweep | None) -> KeptScan:
    place = (event.T_base_laser, T_local_base, node, False, None, event.follows_jump)
    return KeptScan(OLD, event.stamp_ns, with_sweep(event.scan, sweep), *place)


def _event(kept: Kept) -> Event:
    """Return what was kept as an event of a session."""
    if isinstance(kept, KeptScan):
        place = (kept.T_base_laser, kept.T_local_base, kept.follows_jump)
        return ScanEvent(kept.stamp_ns, kept.scan, *place)
    heard = kept.reading
    limits = (heard.range, heard.min_range, heard.max_range, heard.field_of_view)
    poses = (kept.T_base_sonar, kept.T_local_base)
    return RangeEvent(kept.stamp_ns, kept.sensor, *limits, *poses)
