"""Going on with a session: which events of a recording it has not taken yet, and all together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.recordings.events import Event, RangeEvent, Recording, ScanEvent
from grid_mapper.session_files import Session, SessionError


@dataclass(frozen=True)
class TakenUp:
    """A session that a recording goes on with.

    Attributes:
        session: What was saved.
        localizer: As it was then; goes on.
        taken: Events of the recording that it has taken; None for another recording.
        unplaced: Scans of another recording before the robot was found in the session.
    """

    session: Session
    localizer: LoopClosingLocalizer
    taken: int | None
    unplaced: int = 0

    def is_lost(self, localizer: LoopClosingLocalizer) -> bool:
        """Tell whether not one scan of another recording was found in the session."""
        return self.unplaced > 0 and localizer.num_scans == self.session.num_scans

    def rest(self, recording: Recording) -> Recording:
        """Return what of the recording is left to take."""
        return rest_of(recording, self.taken, self.unplaced)

    def all(self, recording: Recording) -> Recording:
        """Return all events of the session, and then what is left of the recording."""
        return together(self.session, self.rest(recording))


def take_up(session: Session, recording: Recording) -> TakenUp:
    """Return a session ready to go on.

    Args:
        session: As it was opened.
        recording: The one to go on with; its events are taken.

    Raises:
        SessionError: It cannot be gone on with.
    """
    taken = num_taken(session, recording)
    return TakenUp(session, session.localizer(), taken)


def num_taken(session: Session, recording: Recording) -> int | None:
    """Return how many of a recording's events a session has taken; None for another recording.

    Raises:
        SessionError: It has taken the whole recording, and another one after it.
    """
    last_scan: Event | None = None
    for number, event in enumerate(recording.events()):
        if _is_same(event, session.last):
            return number + 1
        last_scan = event if isinstance(event, ScanEvent) else last_scan
    if last_scan is not None and any(_is_same(last_scan, event) for event in session.events()):
        raise SessionError(
            f"{session.path} holds this recording already, to its end, and another one after it"
        )
    return None


def rest_of(recording: Recording, taken: int | None, unplaced: int = 0) -> Recording:
    """Return what a session has not taken yet.

    Another recording begins with a jump, whatever its stamps are, behind its first `unplaced`
    scans; readings before that are left out, as no scan says where they were taken.
    """
    original = recording

    def source(recording: Recording) -> Iterator[Event]:
        events = original.events()  # which notes there what it meets
        for _ in range(taken or 0):
            next(events)
        is_begun, left = taken is not None, unplaced
        for event in events:
            if not is_begun:
                if not isinstance(event, ScanEvent):
                    continue
                left -= 1
                if left >= 0:
                    continue
                is_begun, event = True, replace(event, follows_jump=True)
            yield event

    return replace(recording, source=source, num_scans=None)


def together(session: Session, rest: Recording) -> Recording:
    """Return all events of a session, and then the rest of a recording."""
    return replace(rest, source=lambda recording: chain(session.events(), rest.events()))


def all_of(session: Session, recording: Recording) -> Recording:
    """Return all events of a session in place of a recording's."""
    return replace(recording, source=lambda _: session.events())


def first_scans(recording: Recording, num: int) -> Iterator[Event]:
    """Yield the events of a recording up to the scan behind `num` scans."""
    left = num
    for event in recording.events():
        left -= isinstance(event, ScanEvent)
        if left < 0:
            return
        yield event


def _is_same(a: Event, b: Event) -> bool:
    if a.stamp_ns != b.stamp_ns:
        return False
    if isinstance(a, ScanEvent) and isinstance(b, ScanEvent):
        return np.array_equal(a.scan.ranges, b.scan.ranges, equal_nan=True)
    if isinstance(a, RangeEvent) and isinstance(b, RangeEvent):
        same_range = np.array_equal(a.range, b.range, equal_nan=True)
        return same_range and replace(a, range=0.0) == replace(b, range=0.0)
    return False
