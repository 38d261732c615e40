"""What became of a fault."""

from __future__ import annotations

from dataclasses import dataclass

from experiments.faults_judge import Moved


@dataclass(frozen=True)
class Trace:
    """The drive round a fault, for the picture.

    Attributes:
        commands: As they arrived at the simulator.
        motion: True.
        struck_ns: When the fault began.
        due_ns: From when on the robot had to stop.
        end_ns: When the fault ended.
    """

    commands: list[Moved]
    motion: list[Moved]
    struck_ns: int
    due_ns: int
    end_ns: int


@dataclass
class Row:
    """What became of a fault; every value is in the table.

    Attributes:
        recover_s: From its end until the robot drove again, simulated.
        lost: In words: cells of the map, poses, goals.
        trace: For the picture alone.
    """

    name: str
    what: str
    expected: str
    seen: str
    safe: bool
    recovered: bool
    stop_ms: float | None = None
    stand_s: float | None = None
    recover_s: float | None = None
    lost: str = ""
    graph: str = ""
    kind: str = ""
    trace: Trace | None = None

    @property
    def passed(self) -> bool:
        """Whether it is as asked."""
        return self.safe and self.recovered
