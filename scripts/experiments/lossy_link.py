"""A cable between two network devices that loses, delays and doubles: `lossy_link.py A B ...`.

Ethernet frames that come out of one device go into the other. Which are lost, how long each takes
and which go twice is drawn from a seed; frames that take different times overtake each other. The
kernel leaves checksums of UDP to a network card that is not there: they are set to "none given".
"""

from __future__ import annotations

import argparse
import heapq
import select
import socket
import sys
import time
from collections.abc import Callable

import numpy as np

_IP, _UDP = b"\x08\x00", 17
_MAX_FRAME = 65_600
_SAY_EVERY = 100  # frames
_OUTGOING = 4  # socket.PACKET_OUTGOING: our own frames come back


def without_checksum(frame: bytes) -> bytes:
    """Return a frame with the checksum of UDP over IPv4 left out, which is allowed."""
    is_first = len(frame) >= 34 and (frame[20] & 0x1F) == 0 and frame[21] == 0
    if frame[12:14] != _IP or not is_first or frame[23] != _UDP:
        return frame
    at = 14 + 4 * (frame[14] & 0x0F) + 6
    return frame[:at] + b"\x00\x00" + frame[at + 2 :]


def plan(rng: np.random.Generator, loss: float, delay_s: float, double: float) -> list[float]:
    """Return after how long each copy of a frame arrives, s; none if it is lost."""
    if rng.random() < loss:
        return []
    return [float(rng.exponential(delay_s)) for _ in range(1 + (rng.random() < double))]


class Tally:
    """Draws what becomes of frames, and says now and then how many were lost and doubled."""

    def __init__(self, rng: np.random.Generator, loss: float, delay_s: float, double: float):
        self._rng, self._line = rng, (loss, delay_s, double)
        self._num = self._lost = self._doubled = 0

    def draw(self) -> list[float]:
        """Return after how long each copy of the next frame arrives, s."""
        delays = plan(self._rng, *self._line)
        self._num += 1
        self._lost += not delays
        self._doubled += len(delays) > 1
        if self._num % _SAY_EVERY == 0:
            print(f"of {self._num} lost {self._lost}, doubled {self._doubled}", flush=True)
        return delays


def is_multicast(frame: bytes) -> bool:
    """Whether a frame is for a group; a broadcast, as of ARP, is none."""
    return bool(frame[0] & 1) and frame[:6] != b"\xff" * 6


def carry(ends: list[socket.socket], draw: Callable[[], list[float]], is_unicast: bool) -> None:
    """Carry frames for ever; `draw` says when the copies of one arrive."""
    waiting: list[tuple[float, int, int, bytes]] = []
    count = 0
    while True:
        now = time.monotonic()
        while waiting and waiting[0][0] <= now:
            _, _, to, frame = heapq.heappop(waiting)
            ends[to].send(frame)
        timeout = max(waiting[0][0] - now, 0.0) if waiting else 1.0
        for end in select.select(ends, [], [], timeout)[0]:
            frame, address = end.recvfrom(_MAX_FRAME)
            if address[2] == _OUTGOING or (is_unicast and is_multicast(frame)):
                continue
            to, frame = 1 - ends.index(end), without_checksum(frame)
            for delay in draw():
                count += 1
                heapq.heappush(waiting, (time.monotonic() + delay, count, to, frame))


def main() -> int:
    """Carry frames until it is told to end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("devices", nargs=2)
    parser.add_argument("--loss", type=float, default=0.0)
    parser.add_argument("--delay", type=float, default=0.0, help="mean, s")
    parser.add_argument("--double", type=float, default=0.0)
    parser.add_argument("--unicast", action="store_true", help="no multicast, as much wireless")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    ends = []
    for device in args.devices:
        end = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(3))
        end.bind((device, 3))
        ends.append(end)
    tally = Tally(np.random.default_rng(args.seed), args.loss, args.delay, args.double)
    print("linked", flush=True)
    carry(ends, tally.draw, args.unicast)
    return 0


if __name__ == "__main__":
    sys.exit(main())
