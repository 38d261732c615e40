"""Going on with a session: which events of a recording it has not taken yet, and all together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from grid_mapper.recordings.events import Event, Recording, ScanEvent
from grid_mapper.session_files import Session, SessionError

Open = Callable[[], Recording]


def num_taken(session: Session, recording: Recording) -> int | None:
    """Return how many of a recording's events a session has taken; None for another recording.

    Raises:
        SessionError: The recording goes back before the session's end and does not hold it.
    """
    first: Event | None = None
    for number, event in enumerate(recording.events()):
        first = event if first is None else first
        if _is_same(event, session.last):
            return number + 1
    if first is not None and first.stamp_ns <= session.last.stamp_ns:
        raise SessionError(
            f"the recording begins before the end of {session.path} and is not the one it is of"
        )
    return None


def rest_of(recording: Recording, taken: int | None) -> Recording:
    """Return what a session has not taken yet; another recording begins with a jump."""
    original = recording

    def source(recording: Recording) -> Iterator[Event]:
        events = original.events()  # which notes there what it meets
        for _ in range(taken or 0):
            next(events)
        is_begun = taken is not None
        for event in events:
            if isinstance(event, ScanEvent) and not is_begun:
                is_begun = True
                event = replace(event, follows_jump=True)
            yield event

    return replace(recording, source=source, num_scans=None)


def together(session: Session, rest: Recording) -> Recording:
    """Return all events of a session, and then the rest of a recording."""
    return replace(rest, source=lambda recording: chain(session.events(), rest.events()))


def first_scans(recording: Recording, num: int) -> Iterator[Event]:
    """Yield the events of a recording up to the scan behind `num` scans."""
    left = num
    for event in recording.events():
        left -= isinstance(event, ScanEvent)
        if left < 0:
            return
        yield event


def _is_same(a: Event, b: Event) -> bool:
    if a.stamp_ns != b.stamp_ns or type(a) is not type(b):
        return False
    if isinstance(a, ScanEvent) and isinstance(b, ScanEvent):
        return np.array_equal(a.scan.ranges, b.scan.ranges, equal_nan=True)
    return a == b
