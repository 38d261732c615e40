"""Lines of a text log, plain or gzip-compressed, recognized by content."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Callable, Iterator
from io import TextIOWrapper
from pathlib import Path

from grid_mapper.recordings.events import RecordingError

GZIP_MAGIC = b"\x1f\x8b"


def read_head(path: Path, num_bytes: int = 65536) -> bytes:
    """Return the first bytes of a file, unpacked if it is gzip-compressed."""
    with path.open("rb") as raw:
        head = raw.read(num_bytes)
    if not head.startswith(GZIP_MAGIC):
        return head
    try:
        return zlib.decompressobj(wbits=31).decompress(head, num_bytes)
    except zlib.error as error:
        raise RecordingError(f"{path} is not a readable gzip file: {error}") from None


def read_lines(path: Path, on_problem: Callable[[str], None]) -> Iterator[str]:
    """Yield the lines of a log without their ends, be they of Unix, Windows or an old Mac.

    Of a last line that is cut off only the first word is left, so that no half number counts.

    Args:
        path: A text file, plain or gzip-compressed.
        on_problem: Called with one line of text if the file ends early; what was read is kept.
    """
    with path.open("rb") as raw:
        is_gzip = raw.read(2) == GZIP_MAGIC
    number = 0
    before: dict[str, str] = {}
    with gzip.open(path, "rb") if is_gzip else path.open("rb") as stream:
        text = TextIOWrapper(stream, encoding="utf-8-sig", errors="replace")
        try:
            for line in text:
                number += 1
                kind = _kind(line)
                if not line.endswith("\n") and _is_cut(line, kind, before):
                    on_problem(f"{path.name} is cut off in the middle of line {number}")
                    line = line.split(maxsplit=1)[0]
                before[kind] = line
                yield line.rstrip("\n")
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            on_problem(f"{path.name} is cut off or damaged after line {number}: {error}")


def _kind(line: str) -> str:
    """Return the word that tells what a line is; "" for rows of numbers and empty lines."""
    words = line.split(maxsplit=1)
    return words[0] if words and words[0][0].isalpha() else ""


def _is_cut(line: str, kind: str, before: dict[str, str]) -> bool:
    """Tell whether a line without an end is shorter than the one of its kind before it."""
    if kind not in before:
        return any(other.startswith(kind) for other in before if kind)
    return _num_words(line) < _num_words(before[kind])


def _num_words(line: str) -> int:
    return len(line.replace(",", " ").split())
