"""Messages of a whole team, collected into moments: who saw what at one time.

The bearings of one robot, the leader, make a moment: this robot's own, or the first present one's.
It is due once every robot that is present has bearings as new, or when it has waited for long
enough; a newer moment that is due replaces it. Robots that stay silent are not waited for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from multi_localizer.clock_offsets import clock_problem
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.robot_inbox import Classes, RobotInbox, Sight
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_node_config import TeamTimingConfig
from multi_localizer.team_problem import is_vague
from multi_localizer.team_views import RobotView

_MAX_PENDING = 20


@dataclass(frozen=True, eq=False)
class Moment:
    """What the robots of a team saw at one time.

    Attributes:
        stamp_ns: That time.
        sights: Of the robots that tell of it, by name, in the order of the team.
        missing: Why the others do not.
    """

    stamp_ns: int
    sights: Mapping[str, Sight] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)

    @property
    def views(self) -> tuple[RobotView, ...]:
        """What the solver takes."""
        return tuple(sight.view for sight in self.sights.values())


class TeamInbox:
    """Collects what the robots of a team send.

    Times are of two clocks: `now_ns` is that of stamps, `passed_ns` that on which silence counts.

    Args:
        team: Names of all robots.
        own: Name of this robot; "" if it is none of them.
        config: Which messages belong together.
        classes: What bearings may be of.

    Attributes:
        robots: The inbox of each robot.
        solver: Says which poses are too uncertain.
    """

    def __init__(
        self, team: Sequence[str], own: str, config: TeamTimingConfig, classes: Classes
    ) -> None:
        """Start with nothing heard."""
        self.robots = {name: RobotInbox(name, config, classes) for name in team}
        self.solver = TeamConfig()
        self._own = own
        self._config = config
        self._pending: list[tuple[int, int]] = []  # stamp, when it began to wait
        self._last_ns: int | None = None

    def configure(self, config: TeamTimingConfig) -> None:
        """Go on with other values."""
        self._config = config
        for robot in self.robots.values():
            robot.config = config

    def is_present(self, name: str, passed_ns: int) -> bool:
        """Return whether a robot was heard not long ago."""
        heard_ns = self.robots[name].heard_ns
        return heard_ns is not None and self.silence_s(name, passed_ns) <= (
            self._config.robot_timeout_s
        )

    def silence_s(self, name: str, passed_ns: int) -> float:
        """Return for how long a robot that was heard is silent, s."""
        return (passed_ns - (self.robots[name].heard_ns or 0)) / 1e9

    def leader(self, passed_ns: int) -> str:
        """Return whose bearings make moments; "" if nobody is present."""
        present = [name for name in self.robots if self.is_present(name, passed_ns)]
        return self._own if self._own in present else (present[0] if present else "")

    def take_pose(self, name: str, stamp_ns: int, estimate: PoseEstimate, now_ns: int) -> None:
        """Take where a robot believes to be by itself; ValueError if it says that nobody knows."""
        if is_vague(estimate, self.solver):
            raise ValueError("its pose is too uncertain: as if it sent none")
        self.robots[name].take_pose(stamp_ns, estimate, now_ns)

    def note_bearings(self, name: str, passed_ns: int) -> None:
        """Note that new bearings to robots came from a robot, after they were put in its box."""
        self.robots[name].heard_ns = passed_ns
        newest_ns = self.robots[name].newest_ns
        if newest_ns is None or self.leader(passed_ns) != name:
            return
        if self._last_ns is not None and newest_ns < self._last_ns - 1e9 * self._config.carry_s:
            self._last_ns = None  # the leader's clock was set back, or another leads
            self._pending = []
        if self._last_ns is not None and newest_ns <= self._last_ns:
            return
        if newest_ns not in [stamp for stamp, _ in self._pending]:
            self._pending = [*self._pending, (newest_ns, passed_ns)][-_MAX_PENDING:]

    def take_due(self, passed_ns: int) -> Moment | None:
        """Return the newest moment that is due, and forget it with all before; None if none is."""
        due = [each for each in self._pending if self._is_due(*each, passed_ns)]
        if not due:
            return None
        stamp_ns = max(due)[0]
        self._pending = [each for each in self._pending if each[0] > stamp_ns]
        if self._last_ns is not None and stamp_ns <= self._last_ns:
            return None
        self._last_ns = stamp_ns
        return self.collect(stamp_ns, passed_ns)

    def collect(self, stamp_ns: int, passed_ns: int) -> Moment:
        """Return what the robots tell of a moment."""
        sights: dict[str, Sight] = {}
        missing: dict[str, str] = {}
        for name, robot in self.robots.items():
            sight: Sight | str = robot.sight_at(stamp_ns)
            if not self.is_present(name, passed_ns):
                sight = self._away(name, passed_ns)
            if isinstance(sight, Sight):
                sights[name] = sight
            else:
                missing[name] = self._with_clock(robot, sight)
                robot.counts["moments missed"] += 1
        return Moment(stamp_ns, sights, missing)

    def clear(self) -> None:
        """Forget all that has a stamp: our clock jumped."""
        self._pending.clear()
        self._last_ns = None
        for robot in self.robots.values():
            robot.clear()

    def _is_due(self, stamp_ns: int, since_ns: int, passed_ns: int) -> bool:
        if (passed_ns - since_ns) / 1e9 >= self._config.wait_s:
            return True
        awaited = [r for name, r in self.robots.items() if self.is_present(name, passed_ns)]
        return all(r.complete_ns is not None and r.complete_ns >= stamp_ns for r in awaited)

    def _away(self, name: str, passed_ns: int) -> str:
        if self.robots[name].heard_ns is None:
            return "never heard"
        return f"silent for more than {self._config.robot_timeout_s:g} s"

    def _with_clock(self, robot: RobotInbox, reason: str) -> str:
        """Return why a robot is missing, with its clock where that may be the cause."""
        doubt = clock_problem(robot.clock.offset, round(self._config.max_skew_s * 1e9))
        return f"{reason}; {doubt}" if doubt else reason
