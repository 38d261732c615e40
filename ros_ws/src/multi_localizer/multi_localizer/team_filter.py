"""All robots of a team over time, from odometry and bearings: one joint Gaussian, causal.

The poses of the robots are one state, so that a bearing from one to another corrects both and their
errors stay related; what each robot's camera and odometry do wrong (`team_filter_kernels`) is
estimated with them. Robots start, and start again when lost, from bearings alone (`team_start`).

    team = TeamFilter(["r1", "r2"], {"goal": np.array([4.5, 0.0]), ...}, TeamFilterConfig())
    team.predict("r1", motion, stamp_ns)                       # between two odometry messages
    team.update("r1", [Sighting(0.31, ("goal",)), Sighting(-1.2, ("r2", "r3"))], stamp_ns)
    team.estimates()                                           # of the robots that are located

Predict every robot up to the stamp of a picture before its update: a robot seen is where it was
predicted last. Errors of bearings that one place repeats count as alike (`repeat_s`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_gaussian import SensorErrors, TeamGaussian
from multi_localizer.team_meanings import tell_apart
from multi_localizer.team_robot import RobotRecord
from multi_localizer.team_sightings import Looks, Sighting
from multi_localizer.team_start import find_start


class TeamFilter:
    """Poses of a team's robots over time; see the module's text."""

    def __init__(
        self, names: Sequence[str], landmarks: Mapping[str, np.ndarray], config: TeamFilterConfig
    ) -> None:
        twice = sorted({n for n in names if list(names).count(n) > 1} | (set(names) & {*landmarks}))
        if twice:
            raise ValueError(
                f"robots and landmarks must have names of their own, got {twice} twice"
            )
        if not names:
            raise ValueError("names must hold at least one robot, got none")
        self._config = config
        self._robots = {name: RobotRecord(k) for k, name in enumerate(names)}
        self._landmarks = {k: np.asarray(p, float).reshape(2) for k, p in landmarks.items()}
        self._state = TeamGaussian(len(names), config)

    def predict(self, name: str, motion: SE2, stamp_ns: int, cov: np.ndarray | None = None) -> None:
        """Move a robot by its odometry.

        Args:
            name: Which one.
            motion: Its pose at the stamp seen from its pose before, by odometry.
            stamp_ns: Of the new pose; never before the last.
            cov: Covariance of the motion in the axes of the old pose, (3, 3); None for the
                configured noise.
        """
        robot = self._robot(name)
        dt = robot.move(motion, stamp_ns)
        if robot.is_located:
            self._state.move(robot.index, motion, dt, cov)

    def update(self, name: str, sightings: Sequence[Sighting], stamp_ns: int) -> Looks:
        """Correct the team by one picture of a robot.

        Args:
            name: Whose picture.
            sightings: What it shows; a bearing that is NaN is passed over.
            stamp_ns: When it was taken.

        Raises:
            ValueError: If a sighting names something that is neither landmark nor robot.
        """
        robot = self._robot(name)
        for meaning in {m for sighting in sightings for m in sighting.meanings}:
            if meaning not in self._landmarks and meaning not in self._robots:
                raise ValueError(f"a sighting of {name} names {meaning!r}, which is not known")
        taken = [_only(s, name) for s in sightings]
        if robot.is_located:
            taken = self._with_meanings(name, sightings, taken)
        is_used = np.zeros(len(taken), dtype=bool)
        deviations = np.full(len(taken), np.nan)
        for k, (sighting, meaning) in enumerate(zip(sightings, taken, strict=True)):
            if np.isfinite(sighting.bearing):
                var = robot.bearing_var(meaning, stamp_ns, self._config)
                if meaning and robot.is_located and self._is_placed(meaning):
                    target = self._target(meaning)
                    square, used = self._state.learn(robot.index, sighting.bearing, target, var)
                    deviations[k], is_used[k] = square, used
                    robot.outcomes.append(used)
                self._remember(name, sighting, meaning, var, stamp_ns)
        self._settle(name, stamp_ns)
        return Looks(tuple(taken), is_used, deviations)

    def estimates(self) -> dict[str, PoseEstimate]:
        """Return the poses of the robots that are located, each as of its last motion."""
        return {
            name: self._state.pose(robot.index)
            for name, robot in self._robots.items()
            if robot.is_located
        }

    def errors_of(self, name: str) -> SensorErrors:
        """Return what the sensors of a robot do wrong, as estimated so far."""
        return self._state.errors(self._robot(name).index)

    def expect(self, name: str, sighting: Sighting) -> tuple[float, float] | None:
        """Return how far a bearing is off, rad, and its variance, rad^2, and learn nothing of it.

        None if the robot or what it sees is not located, or the sighting has several meanings.
        """
        robot, meaning = self._robot(name), _only(sighting, name)
        if not (meaning and robot.is_located and self._is_placed(meaning)):
            return None
        off, var = self._state.expect(robot.index, sighting.bearing, self._target(meaning))
        return None if var < 0.0 else (off, var + self._config.bearing_sd_rad**2)

    def place(self, name: str, estimate: PoseEstimate) -> None:
        """Say where a robot is, from another source; what was known of its pose is dropped."""
        robot = self._robot(name)
        self._state.place(robot.index, estimate)
        robot.find()

    def place_jointly(
        self, fresh: Sequence[str], held: Sequence[str], mean: np.ndarray, cov: np.ndarray
    ) -> None:
        """Say where robots are by one answer for them and for others that are located.

        Args:
            fresh: Whom to place; what was known of their poses is dropped.
            held: The others; they stay where they are.
            mean: x, y, yaw of all by that answer, `fresh` first, (3 (F + H),).
            cov: Of that.
        """
        fresh_indices, held_indices = ([self._robot(n).index for n in g] for g in (fresh, held))
        self._state.place_jointly(fresh_indices, held_indices, mean, cov)
        for name in fresh:
            self._robots[name].find()

    def update_pose(self, name: str, estimate: PoseEstimate, stamp_ns: int) -> bool:
        """Correct the team by a robot's pose from another source; return whether it was used.

        One that follows another soon is like it, and counts for less, as with bearings.
        """
        robot = self._robot(name)
        if not robot.is_located:
            return False
        wider = robot.times_wider(name, stamp_ns, self._config)
        used = self._state.learn_pose(
            robot.index, PoseEstimate(estimate.pose, wider * estimate.cov)
        )
        if used:
            robot.seen_ns[name] = stamp_ns
        return used

    def note_seen(self, name: str, meaning: str, stamp_ns: int) -> None:
        """Note that a robot's look at something is in the poses already."""
        self._robot(name).seen_ns[meaning] = stamp_ns

    def forget(self, name: str) -> None:
        """Drop all that is known of a robot and its way, as when its odometry has a gap."""
        self._state.clear(self._robot(name).index)
        self._robots[name].start_anew()

    def _robot(self, name: str) -> RobotRecord:
        if name not in self._robots:
            raise ValueError(f"name must be one of {sorted(self._robots)}, got {name!r}")
        return self._robots[name]

    def _is_placed(self, meaning: str) -> bool:
        return meaning in self._landmarks or self._robots[meaning].is_located

    def _target(self, meaning: str) -> int | np.ndarray:
        if meaning in self._landmarks:
            return self._landmarks[meaning]
        return self._robots[meaning].index

    def _with_meanings(
        self, name: str, sightings: Sequence[Sighting], taken: list[str]
    ) -> list[str]:
        """Return what each bearing is taken for, those of several meanings told by geometry."""
        answer = list(taken)
        open_rows = [k for k, s in enumerate(sightings) if not answer[k] and np.isfinite(s.bearing)]
        things = sorted({m for k in open_rows for m in sightings[k].meanings} - {name})
        placed = [thing for thing in things if self._is_placed(thing)]
        fits = np.full((len(open_rows), len(placed)), -np.inf)
        for i, k in enumerate(open_rows):
            for j, thing in enumerate(placed):
                if thing in sightings[k].meanings and thing not in taken:
                    fits[i, j] = self._log_fit(name, sightings[k].bearing, thing)
        unplaced = len(things) - len(placed)
        log_nothing = np.log((self._config.false_share + unplaced) / (2.0 * np.pi))
        chosen = tell_apart(fits, float(log_nothing), self._config.identity_odds)
        for k, column in zip(open_rows, chosen, strict=True):
            answer[k] = placed[column] if column >= 0 else ""
        return answer

    def _log_fit(self, name: str, bearing: float, meaning: str) -> float:
        expected = self.expect(name, Sighting(bearing, (meaning,)))
        if expected is None or expected[0] ** 2 > expected[1] * self._config.gate_sd**2:
            return -np.inf
        off, var = expected
        return float(-0.5 * (off * off / var + np.log(2.0 * np.pi * var)))

    def _remember(
        self, name: str, sighting: Sighting, meaning: str, var: float, stamp_ns: int
    ) -> None:
        """Keep a bearing as a clue of where its robot is, and where the robot it shows is."""
        robot = self._robots[name]
        if meaning:
            robot.seen_ns[meaning] = stamp_ns
        things = [meaning] if meaning else [m for m in sighting.meanings if m != name]
        if things and all(self._is_placed(thing) for thing in things):
            places = [self._position(thing) for thing in things]
            points = np.concatenate([place for place, _ in places])
            spread = max(spread for _, spread in places)
            robot.add_clue(stamp_ns, sighting.bearing, var, points, spread)
        elif meaning in self._robots and robot.is_located:
            place, spread = self._state.position(robot.index)
            angle, own_var = self._state.direction(robot.index, sighting.bearing)
            seen = self._robots[meaning]
            seen.add_clue(stamp_ns, angle, var + own_var, place, spread, True)
            self._settle(meaning, stamp_ns)

    def _position(self, thing: str) -> tuple[np.ndarray, float]:
        """Return where a landmark or a located robot is, (1, 2), and the variance of that, m^2."""
        if thing in self._landmarks:
            return self._landmarks[thing].reshape(1, 2), 0.0
        return self._state.position(self._robots[thing].index)

    def _settle(self, name: str, stamp_ns: int) -> None:
        """Drop old clues, notice that a robot is lost, and start one that is not located."""
        robot, config = self._robots[name], self._config
        robot.trim(stamp_ns, config)
        if robot.is_lost(config):
            self._state.clear(robot.index)
            robot.lose(config)
        if self._landmarks and robot.is_start_due(stamp_ns):
            middle = np.array(list(self._landmarks.values()))
            start = find_start(list(robot.clues), robot.driven, middle, config)
            if start is not None:
                self.place(name, start)


def _only(sighting: Sighting, name: str) -> str:
    """Return a sighting's meaning if it has one only, "" otherwise."""
    meanings = [m for m in sighting.meanings if m != name]
    return meanings[0] if len(meanings) == 1 else ""
