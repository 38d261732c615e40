"""Sessions of the mapping node: the one to begin with, and the file to save its own in."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from floornav_common.ros.diagnostics import OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.session_files import load_session

LOOK_S = 0.05
SAVING_S = 15.0
"""How long the end of a node waits for its session."""


@dataclass(frozen=True)
class StartSession:
    """A session to begin with: its file, and the localizer in it."""

    path: str
    localizer: LoopClosingLocalizer


def read_start_session(
    config: GridMapperNodeConfig, mapper_config: GridMapperConfig
) -> StartSession | None:
    """Return the session to begin with; None where none is asked for.

    Raises:
        ParameterError: It cannot be taken up, or none can be saved as asked.
    """
    if config.session_file:
        _require_place(Path(config.session_file))
    path = config.start_session
    for name in ("start_session", "session_file"):
        if not getattr(config, name):
            continue
        if not mapper_config.loop_closing:
            raise ParameterError(f"{name}: sessions are of graphs; loop_closing is false")
        if find_spec("gtsam") is None:
            raise ParameterError(f"{name}: sessions need gtsam (requirements-robot.txt)")
    if not path:
        return None
    try:
        return StartSession(path, load_session(Path(path), mapper_config).localizer())
    except ValueError as error:
        raise ParameterError(f"start_session: {' '.join(str(error).split())}") from error


def wait_for_maps(node: FloornavNode, mapper: LayeredMapper | ClosingMapper) -> None:
    """Wait until the maps of a session are made.

    Raises:
        ParameterError: They cannot be.
    """
    assert isinstance(mapper, ClosingMapper)
    node.get_logger().info("making the maps of the session")
    while mapper.num_swaps == 0:
        if mapper.failure:
            raise ParameterError(f"start_session: {mapper.failure}")
        time.sleep(LOOK_S)
        mapper.take_news()


class SessionSaver:
    """Has the session saved, and says what became of it; without a file it does nothing."""

    def __init__(
        self, node: FloornavNode, mapper: LayeredMapper | ClosingMapper, path: str
    ) -> None:
        self._node, self._mapper, self._path = node, mapper, path
        self._num_asked = self._num_answered = 0

    def save(self) -> None:
        """Ask the background to save; returns at once."""
        if not self._path or not isinstance(self._mapper, ClosingMapper):
            return
        if self._mapper.failure:
            self._say(f"the session was not saved: {self._mapper.failure}")
            return
        self._mapper.link.save(self._path)
        self._num_asked += 1

    def look(self) -> None:
        """Say what was saved since."""
        if self._num_asked == self._num_answered or not isinstance(self._mapper, ClosingMapper):
            return
        self._mapper.take_news()
        while self._mapper.link.saved:
            saved = self._mapper.link.saved.popleft()
            self._num_answered += 1
            self._say(f"the session was not saved: {saved.problem}" if saved.problem else "")

    def finish(self) -> None:
        """Save, and wait until that is done."""
        self.save()
        end = time.monotonic() + SAVING_S
        while self._num_answered < self._num_asked and isinstance(self._mapper, ClosingMapper):
            self.look()
            late = f"not done within {SAVING_S:g} s" if time.monotonic() > end else ""
            if problem := self._mapper.failure or late:
                self._say(f"the session was not saved: {problem}")
                return
            time.sleep(LOOK_S)

    def _say(self, problem: str) -> None:
        words = problem or f"session saved: {self._path}"
        self._node.diagnostics.set("session", Status(WARN if problem else OK, words))
        if problem:
            self._node.get_logger().error(problem)
        else:
            self._node.get_logger().info(words)


def _require_place(path: Path) -> None:
    if not path.parent.is_dir():
        raise ParameterError(f"session_file: there is no folder {path.parent}")
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise ParameterError(f"session_file: {path} cannot be written")
