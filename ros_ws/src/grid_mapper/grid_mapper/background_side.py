"""The other side of work in the background: it reads messages, does the work, writes answers.

Run as `python -m grid_mapper.background_side`. It ends when its input does, so it outlives nobody
who was killed; it leaves Ctrl-C to the one who started it.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import sys
from contextlib import suppress
from threading import Thread
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grid_mapper.background import Work

NICENESS = 5
TAKEN_A_STEP = 20
"""Messages taken between two steps of work: neither waits for the other for ever."""
_LENGTH_BYTES = 8
_NOTHING = object()


def write_message(stream: IO[bytes], message: Any) -> None:
    """Write one message."""
    data = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(len(data).to_bytes(_LENGTH_BYTES, "little"))
    stream.write(data)
    stream.flush()


def read_message(stream: IO[bytes]) -> Any | None:
    """Return the next message; None at the end."""
    data = read_data(stream)
    return None if data is None else pickle.loads(data)


def read_data(stream: IO[bytes]) -> bytes | None:
    """Return the bytes of the next message; None at the end, also in the middle of one."""
    head = stream.read(_LENGTH_BYTES)
    if len(head) < _LENGTH_BYTES:
        return None
    size = int.from_bytes(head, "little")
    data = stream.read(size)
    return data if len(data) == size else None


def serve(source: IO[bytes], sink: IO[bytes]) -> None:
    """Make the work that the first message names, and do it until the messages end."""
    first = read_message(source)
    if first is None:
        return
    make_work, args = first
    work: Work = make_work(*args)
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    Thread(target=_read_all, args=(source, messages), daemon=True).start()
    num_taken = 0
    while True:
        message = _NOTHING
        if not work.has_work or num_taken < TAKEN_A_STEP:
            with suppress(queue.Empty):
                message = messages.get(block=not work.has_work)
        if message is None:
            return
        if message is _NOTHING:
            num_taken, answer = 0, work.work()
        else:
            num_taken, answer = num_taken + 1, work.take(message)
        if answer is not None:
            write_message(sink, answer)


def _read_all(source: IO[bytes], messages: queue.SimpleQueue[Any]) -> None:
    while (message := read_message(source)) is not None:
        messages.put(message)
    messages.put(None)


def main() -> None:
    """Serve over standard input and output; what is printed goes to standard error."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    os.nice(NICENESS)
    with os.fdopen(os.dup(1), "wb") as sink:
        os.dup2(2, 1)
        try:
            serve(sys.stdin.buffer, sink)
        except BrokenPipeError:
            os._exit(0)  # nobody listens any more
        sink.flush()
    os._exit(0)  # the reading thread may be in the middle of a read


if __name__ == "__main__":
    main()
