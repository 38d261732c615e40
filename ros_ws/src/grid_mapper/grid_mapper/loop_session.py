"""The background of a live mapper: closes loops and makes all maps anew at the corrected poses.

It is given what was kept, one after the other, and worked in small steps, so that whoever runs it
can take in what comes meanwhile. Maps made anew hold everything up to the newest event known.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grid_mapper.config import GridMapperConfig
from grid_mapper.corrections import Corrections
from grid_mapper.front_end import key_frame
from grid_mapper.kept_archive import KeptArchive
from grid_mapper.kept_events import Kept, KeptScan
from grid_mapper.layers import LayeredMapper
from grid_mapper.live_sessions import kept_of, save_live
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.pose_graph import load_solver
from grid_mapper.session_files import Session, load_session

EVENTS_A_STEP = 50
EVENTS_AN_ANSWER = 100
REST_SHARE = 0.01
"""Of all events so many have to come before maps are made anew again: else it never rests."""
WORTH_M, WORTH_RAD = 0.01, 0.002
"""Maps are made anew once a pose has moved by more."""


@dataclass(frozen=True)
class Restart:
    """Says to forget all and go on by a configuration; with the number of an event."""

    number: int
    config: GridMapperConfig


@dataclass(frozen=True)
class Retune:
    """Says to make maps by another configuration from now on; the graph keeps its own."""

    config: GridMapperConfig


@dataclass(frozen=True)
class Save:
    """Says to save the session in a file."""

    path: str


@dataclass(frozen=True)
class Saved:
    """What became of a session to save; `problem` is why it is not, "" if it is."""

    path: str
    problem: str = ""


@dataclass(frozen=True)
class GraphState:
    """How the graph is.

    Attributes:
        number: Of the newest event taken in.
        num_nodes: Nodes.
        num_loops: Loops closed.
        num_refused: Candidates that were none.
    """

    number: int
    num_nodes: int = 0
    num_loops: int = 0
    num_refused: int = 0


@dataclass(frozen=True)
class Rebuilt:
    """Maps made anew.

    Attributes:
        number: Of the newest event in them.
        mapper: The maps.
        corrections: The poses they were made at.
    """

    number: int
    mapper: LayeredMapper
    corrections: Corrections


Answer = GraphState | Rebuilt | Saved


class LoopSession:
    """Takes events, answers with how the graph is and with maps.

    Args:
        config: Its values.
        start: File of a session to go on with; "" to begin anew.

    Raises:
        SessionError: That session cannot be taken up.
    """

    def __init__(self, config: GridMapperConfig, start: str = "") -> None:
        load_solver()
        self._restart(config)
        if start:
            self._take_up(load_session(Path(start), config))

    def _restart(self, config: GridMapperConfig) -> None:
        self._config = config
        self._closer = LoopCloser(config)
        self._archive = KeptArchive()
        self._mapped = Corrections.of([], [])
        self._rebuild: _Rebuild | None = None
        self._number = self._rebuilt_number = -1
        self._has_moved = False

    def _take_up(self, session: Session) -> None:
        """Go on with a session; its maps are made first of all."""
        localizer = session.localizer()
        self._closer = localizer.closer
        for event in kept_of(session.events(), localizer.followed):
            self._archive.add(event)
        if self._archive.is_full:
            self._archive.thin(self._corrections())
        self._rebuild = _Rebuild(self._config, self._corrections())

    def take(self, event: Kept | Restart | Retune | Save) -> Answer | None:
        """Take an event; a node's, and every so many, are answered with how the graph is."""
        if isinstance(event, Restart):
            self._restart(event.config)
            return None
        if isinstance(event, Retune):
            self._config = event.config
            return None
        if isinstance(event, Save):
            return self._save(event.path)
        self._archive.add(event)
        self._number = event.number
        if not (isinstance(event, KeptScan) and event.is_node):
            return self._state() if event.number % EVENTS_AN_ANSWER == 0 else None
        seen = (event.stamp_ns, event.scan, event.T_base_laser, event.T_local_base)
        frame = key_frame(*seen, event.information, self._config)
        self._has_moved |= self._closer.add(frame, follows_jump=event.follows_jump)
        return self._state()

    def _save(self, path: str) -> Saved:
        try:
            save_live(Path(path), self._closer, self._archive)
        except (OSError, ValueError) as error:
            return Saved(path, " ".join(str(error).split()))
        return Saved(path)

    @property
    def has_work(self) -> bool:
        """Whether `work` would do anything."""
        is_rested = self._number - self._rebuilt_number >= REST_SHARE * len(self._archive)
        has_moved = self._has_moved and is_rested
        return self._rebuild is not None or has_moved or self._archive.is_full

    def work(self) -> Answer | None:
        """Do a step of what there is to do; return maps once they are ready."""
        if self._rebuild is None:
            self._begin()
            return None
        if not self._rebuild.step(self._archive):
            return None
        done, self._rebuild = self._rebuild, None
        self._mapped, self._rebuilt_number = done.corrections, self._number
        return Rebuilt(self._number, done.mapper, done.corrections)

    def _begin(self) -> None:
        """Begin to make maps, if poses have moved enough for that; throw out what is too much."""
        corrections = self._corrections()
        if self._archive.is_full:
            self._archive.thin(corrections)
        if self._has_moved and moved_far(self._mapped, corrections):
            self._rebuild = _Rebuild(self._config, corrections)
        self._has_moved = False

    def _corrections(self) -> Corrections:
        return Corrections.of([f.T_local_base for f in self._closer.frames], self._closer.poses)

    def _state(self) -> GraphState:
        refused = sum(self._closer.refused.values())
        num_nodes, num_loops = len(self._closer.frames), self._closer.num_loops
        return GraphState(self._number, num_nodes, num_loops, refused)


class _Rebuild:
    """Maps in the making."""

    def __init__(self, config: GridMapperConfig, corrections: Corrections) -> None:
        self.mapper, self.corrections = LayeredMapper(config), corrections
        self._next = 0

    def step(self, archive: KeptArchive) -> bool:
        """Map some more events; tell whether that was all."""
        events = list(archive.from_index(self._next, EVENTS_A_STEP))
        map_events(self.mapper, events, self.corrections)
        self._next += len(events)
        return self._next == len(archive)


def map_events(mapper: LayeredMapper, events: list[Kept], corrections: Corrections) -> None:
    """Map events at their corrected poses."""
    if not events:
        return
    poses = corrections.all_at(
        np.array([event.node for event in events], int),
        np.array([event.T_local_base.as_array() for event in events]),
    )
    for event, pose in zip(events, corrections.as_poses(poses), strict=True):
        if isinstance(event, KeptScan):
            mapper.place_scan(event.stamp_ns, event.scan, event.T_base_laser, pose)
        else:
            place = (event.T_base_sonar, event.sensor, pose)
            mapper.place_range(event.stamp_ns, event.reading, *place)


def moved_far(before: Corrections, now: Corrections) -> bool:
    """Tell whether poses have moved so far that maps are worth making anew."""
    expected = before.all_at(np.arange(len(now.local)), now.local)
    off = np.abs(expected - now.solved)
    off[:, 2] = np.minimum(off[:, 2], abs(2.0 * np.pi - off[:, 2]))
    return bool((off > (WORTH_M, WORTH_M, WORTH_RAD)).any())
