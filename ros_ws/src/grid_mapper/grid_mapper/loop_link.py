"""The line to the background of a live mapper: what is sent, what is not answered to, new maps.

Maps made anew in the background hold all but the newest events; these are mapped a few at a time,
so that nobody waits, and once none is left the maps are handed over.
"""

from __future__ import annotations

import time
from collections import deque
from typing import Any

from grid_mapper.background import Worker
from grid_mapper.config import GridMapperConfig
from grid_mapper.kept_events import Kept
from grid_mapper.loop_session import (
    GraphState,
    Rebuilt,
    Restart,
    Retune,
    Save,
    Saved,
    map_events,
)

REPLAY_S = 0.01
"""Time taken at once to bring maps made anew up to now."""
REPLAYED_AT_ONCE = 5
MAX_PENDING = 50_000
"""Events that the background may be behind; then it is given up."""
TOO_SLOW = "closing loops takes longer than driving: given up until ~/reset"


class LoopLink:
    """Numbers events and sends them; takes what comes back.

    Once it has failed nothing is sent and nothing taken until `restart`: the background would not
    know all nodes and events any more.

    Attributes:
        graph: How the graph was when last heard of.
        saved: What became of sessions to save, oldest first; take them out.
    """

    def __init__(self, worker: Worker) -> None:
        self._worker = worker
        self.saved: deque[Saved] = deque()
        self._coming: tuple[Rebuilt, deque[Kept]] | None = None
        self._num_events = 0
        self._begin()
        self._first_number = -1  # maps of a session that the background begins with are news too

    def restart(self, config: GridMapperConfig) -> None:
        """Let the background forget all and go on by a configuration; one that died begins anew."""
        if self._worker.failure:
            self._worker.begin_anew()
        self._worker.send(Restart(self._num_events, config))
        self._num_events += 1
        self._begin()

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Let maps be made by other values from now on."""
        self._worker.send(Retune(config))

    def send(self, kind: type[Kept], *seen: Any) -> None:
        """Send an event of a kind; `seen` is what it holds beside its number."""
        if self.failure:
            return
        if len(self._pending) >= MAX_PENDING:
            self._given_up = TOO_SLOW
            self._worker.begin_anew()  # it need not go on through all that it was sent
            return
        event = kind(self._num_events, *seen)
        self._num_events += 1
        self._worker.send(event)
        self._pending.append(event)
        if self._coming is not None:
            self._coming[1].append(event)

    def save(self, path: str) -> None:
        """Let the session be saved by the background; `saved` tells once it is."""
        self._worker.send(Save(path))

    def take(self) -> Rebuilt | None:
        """Take what the background has to say; return new maps once all that was sent is in."""
        self._take_answers()
        if self.failure:
            self._pending.clear()
            self._coming = None
        if self._coming is None or not _is_up_to_now(*self._coming):
            return None
        done, self._coming = self._coming[0], None
        return done

    @property
    def num_behind(self) -> int:
        """Events that the background has not answered to."""
        return len(self._pending)

    @property
    def failure(self) -> str:
        """Why no loops are closed any more; "" while they are."""
        return self._given_up or self._worker.failure

    @property
    def longest_read_ms(self) -> float:
        """The longest that an answer took to be read: meanwhile nothing else goes on."""
        return self._worker.longest_read_ms

    def close(self) -> None:
        """End the background."""
        self._worker.close()

    def _begin(self) -> None:
        self.graph, self._given_up = GraphState(-1), ""
        self._pending: deque[Kept] = deque()
        self._coming = None
        self._first_number = self._num_events

    def _take_answers(self) -> None:
        while (answer := self._worker.receive()) is not None:
            if isinstance(answer, Saved):
                self.saved.append(answer)
                continue
            if answer.number < self._first_number:
                continue  # of what was forgotten since
            while self._pending and self._pending[0].number <= answer.number:
                self._pending.popleft()
            if isinstance(answer, GraphState):
                self.graph = answer
            else:
                self._coming = (answer, deque(self._pending))


def _is_up_to_now(rebuilt: Rebuilt, events: deque[Kept]) -> bool:
    """Map some of the events; tell whether the maps hold all."""
    until = time.perf_counter() + REPLAY_S
    while events and time.perf_counter() < until:
        some = [events.popleft() for _ in range(min(REPLAYED_AT_ONCE, len(events)))]
        map_events(rebuilt.mapper, some, rebuilt.corrections)
    return not events
