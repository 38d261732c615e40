"""People in a world file: walkers with a plan, a crowd drawn by seed, recorded people."""

from __future__ import annotations

import math
from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class WalkerPlan:
    """One person: where it goes, how fast, when; and whether it heeds robots and others.

    Attributes:
        name: For reports.
        path_m: Way points; the first is the start, one alone means standing there.
        speed_m_s: Walking speed; 0 draws one by seed.
        pauses_s: Rest at each way point, the first included; fewer than way points = none there.
        starts_s: When it sets out.
        starts_within_m: Sets out once its body is this near the laser of a robot (the middle of
            its footprint if it has none), after `starts_s`; 0 = at once.
        repeats: Walks to and fro between the ends.
        is_reacting: False walks its plan whatever comes. True keeps clear of walls and people,
            and of a robot once it is noticed.
        never_notices: True or False settles whether it never does, which is otherwise drawn by
            seed; noticing distance and time are drawn all the same.
    """

    name: str
    path_m: tuple[Point, ...]
    speed_m_s: float = 0.0
    pauses_s: tuple[float, ...] = ()
    starts_s: float = 0.0
    starts_within_m: float = 0.0
    repeats: bool = False
    is_reacting: bool = False
    never_notices: bool | None = None

    def __post_init__(self) -> None:
        if not self.path_m:
            raise ValueError(f"path_m of {self.name!r} must hold at least one point")
        if any(math.dist(a, b) < 1e-6 for a, b in zip(self.path_m, self.path_m[1:], strict=False)):
            raise ValueError(f"path_m of {self.name!r} holds a leg of zero length")
        if len(self.pauses_s) > len(self.path_m):
            raise ValueError(
                f"pauses_s of {self.name!r} must not be longer than path_m = {len(self.path_m)}, "
                f"got {len(self.pauses_s)}"
            )
        for name in ("speed_m_s", "starts_s", "starts_within_m"):
            if getattr(self, name) < 0.0:
                raise ValueError(
                    f"{name} of {self.name!r} must be >= 0, got {getattr(self, name):g}"
                )
        if min(self.pauses_s, default=0.0) < 0.0:
            raise ValueError(f"pauses_s of {self.name!r} must be >= 0, got {list(self.pauses_s)}")


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """Reacting walkers between places drawn by seed inside a rectangle."""

    num: int
    low_m: Point
    high_m: Point
    num_goals: int = 6
    free_m: float = 0.5

    def __post_init__(self) -> None:
        if not 0 <= self.num <= 200:
            raise ValueError(f"num must be in 0..200, got {self.num}")
        if self.num_goals < 2:
            raise ValueError(f"num_goals must be >= 2, got {self.num_goals}")
        if not all(a < b for a, b in zip(self.low_m, self.high_m, strict=True)):
            raise ValueError(
                f"low_m must be below high_m, got {list(self.low_m)}, {list(self.high_m)}"
            )


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Recorded people of an `obsmat` file (ETH/UCY: frame id x z y vx vz vy, m and m/s).

    Attributes:
        file: Path of the file, plain or .gz; a relative one from the working folder.
        frames_per_s: Frames of the video in a second.
        starts_s: Time of the recording at simulated time 0.
        low_m: Lower corner of the region that is used, in the recording.
        high_m: Its upper corner.
        position_m: Where the recording's origin lies in the world.
        yaw_deg: How the recording's x axis lies in the world.
    """

    file: str
    frames_per_s: float = 25.0
    starts_s: float = 0.0
    low_m: Point = (-1e6, -1e6)
    high_m: Point = (1e6, 1e6)
    position_m: Point = (0.0, 0.0)
    yaw_deg: float = 0.0

    def __post_init__(self) -> None:
        if self.frames_per_s <= 0.0:
            raise ValueError(f"frames_per_s must be > 0, got {self.frames_per_s:g}")
