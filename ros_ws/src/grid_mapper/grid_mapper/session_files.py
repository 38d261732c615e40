"""A mapping session as a file: the graph with its key scans, the front end, and what maps are of.

Taking it up and going on gives to the bit what one run over everything gives. The file is a zip:
`head` says what it is and by which parameters it was made, `state` is the localizer, and `events/`
holds scans and readings as they came, from which the maps are made anew. Nothing in it is run.
"""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper import loop_localizer
from grid_mapper.after_jump import Guess
from grid_mapper.config import GridMapperConfig
from grid_mapper.dead_reckoning import Step
from grid_mapper.key_frames import Edge, KeyFrame
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.recordings.events import Event, RangeEvent, ScanEvent
from grid_mapper.session_codec import packed, unpacked
from grid_mapper.surface_points import SurfacePoints

FORMAT, VERSION = "floornav mapping session", 6
EVENTS_A_PART = 500
LEFT_OUT = frozenset({"config", "_key", "_solver"})
"""Attributes that follow from the parameters or from the rest."""
KINDS: dict[str, type] = {
    kind.__name__: kind
    for kind in (
        SE2, Scan, SurfacePoints, KeyFrame, Edge, ScanEvent, RangeEvent, Step,
        Guess, loop_localizer._Followed,
    )
}  # fmt: skip
_NO_STATE = (KeyError, ValueError, TypeError, AttributeError, IndexError, RecursionError)
"""What may be raised where something else was saved than what is said."""
_DATE = (1980, 1, 1, 0, 0, 0)  # the same session gives the same bytes


class SessionError(ValueError):
    """A file that is no session, or not one to go on with; the message is one line."""


@dataclass(frozen=True)
class Session:
    """A session that was saved.

    Attributes:
        path: The file.
        config: By which it was made.
        num_scans: Scans in it.
        last: What it took last.
        num_parts: Parts that the events are in.
    """

    path: Path
    config: GridMapperConfig
    num_scans: int
    last: Event
    num_parts: int

    def localizer(self) -> LoopClosingLocalizer:
        """Return a localizer that goes on where this session ended.

        Raises:
            SessionError: What was saved is not a localizer's state.
        """
        fresh = LoopClosingLocalizer(self.config)
        try:
            unpacked(_read(self.path, "state"), KINDS, fresh, LEFT_OUT)
        except _NO_STATE as error:
            raise SessionError(f"{self.path} is damaged: {error}") from error
        return fresh

    def events(self) -> Iterator[Event]:
        """Yield all that it has taken.

        Raises:
            SessionError: Something in it is no event.
        """
        for part in range(self.num_parts):
            yield from _events(self.path, part)


def save_session(path: Path, so_far: LoopClosingLocalizer, events: Iterable[Event]) -> None:
    """Write a session, whole or not at all.

    Args:
        path: The file; one that is there is replaced.
        so_far: The localizer before its graph is finished.
        events: All that it has taken, in order.

    Raises:
        ValueError: It has taken nothing.
    """
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file, zipfile.ZipFile(file, "w") as archive:
            _write(archive, "state", packed(so_far, LEFT_OUT))
            _write(archive, "head", _head(so_far.config, *_write_events(archive, events)))
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def load_session(path: Path, config: GridMapperConfig) -> Session:
    """Open a session to go on with.

    Args:
        path: The file.
        config: The parameters now; they have to be those that it was made by.

    Raises:
        SessionError: It cannot be read, is no session, damaged, or made by other parameters.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            broken = archive.testzip()
            head = json.loads(archive.read("head")) if broken is None else {}
    except OSError as error:
        raise SessionError(f"{path}: {error.strerror or error}") from error
    except (zipfile.BadZipFile, zlib.error, EOFError, *_NO_STATE) as error:
        raise SessionError(f"{path} is no session of map_bag, or is cut off") from error
    if broken is not None:
        raise SessionError(f"{path} is damaged: {broken} does not fit its checksum")
    try:
        _require_same(path, head, config)
        num_scans, num_parts = int(head["scans"]), int(head["parts"])
        return Session(path, config, num_scans, _events(path, num_parts - 1)[-1], num_parts)
    except SessionError:
        raise
    except _NO_STATE as error:
        raise SessionError(f"{path} is damaged: {error}") from error


def _events(path: Path, part: int) -> list[Event]:
    try:
        events = list(unpacked(_read(path, _part(part)), KINDS))
    except _NO_STATE as error:
        raise SessionError(f"{path} is damaged: {error}") from error
    for event in events:
        if not isinstance(event, Event):
            raise SessionError(f"{path} is damaged: a {type(event).__name__} among its events")
    return events


def _require_same(path: Path, head: Any, config: GridMapperConfig) -> None:
    if not isinstance(head, dict) or head.get("format") != FORMAT:
        raise SessionError(f"{path} is no session of map_bag")
    if head.get("version") != VERSION:
        version = head.get("version")
        raise SessionError(f"{path} is of version {version}, this floornav reads {VERSION}")
    there, here = _flat(head["config"]), _flat(asdict(config))
    for name in sorted(there.keys() | here.keys()):
        if there.get(name) != here.get(name):
            was, now = there.get(name), here.get(name)
            raise SessionError(f"{path} was made with {name} {was}, which is {now} now")


def _flat(config: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested values by dotted names, tuples as lists."""
    flat: dict[str, Any] = {}
    for key, value in config.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = list(value) if isinstance(value, tuple) else value
    return flat


def _head(config: GridMapperConfig, num_scans: int, num_parts: int) -> bytes:
    if num_parts == 0:
        raise ValueError("there is nothing to save: not one event was taken")
    head = {
        "format": FORMAT, "version": VERSION, "config": asdict(config), "scans": num_scans,
        "parts": num_parts,
    }  # fmt: skip
    return json.dumps(head).encode()


def _write_events(archive: zipfile.ZipFile, events: Iterable[Event]) -> tuple[int, int]:
    """Write the events, some at a time; return how many are scans, and the number of parts."""
    left, num_scans, num_parts = iter(events), 0, 0
    while part := list(islice(left, EVENTS_A_PART)):
        _write(archive, _part(num_parts), packed(part))
        num_scans += sum(isinstance(event, ScanEvent) for event in part)
        num_parts += 1
    return num_scans, num_parts


def _part(number: int) -> str:
    return f"events/{number:06d}"


def _write(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    info = zipfile.ZipInfo(name, _DATE)
    info.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(info, data)


def _read(path: Path, name: str) -> bytes:
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)
