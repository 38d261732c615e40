"""The joint Gaussian of a team: all poses, and what each robot's camera and odometry do wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference, mahalanobis
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_filter_kernels import (
    CURVE,
    DRAG,
    NOT_A_ROBOT,
    OFFSET,
    SCALE,
    SIZE,
    TRAVEL,
    TURN,
    YAW,
    learn,
    look,
    predict_robot,
)


@dataclass(frozen=True)
class SensorErrors:
    """What a robot's sensors do wrong.

    Attributes:
        offset: Angle that all bearings are off by, rad.
        scale: Factor that bearings are stretched by, less 1.
        travel: Factor of the way that the odometry leaves out, less 1.
        turn: Factor of the turns that the odometry leaves out, less 1.
        curve: Curve driven when told to go straight, rad/m.
        drag: What `travel` grows by with the rate of turning, s.
    """

    offset: float
    scale: float
    travel: float
    turn: float
    curve: float
    drag: float


class TeamGaussian:
    """Mean and covariance of `SIZE` states a robot (`team_filter_kernels`)."""

    def __init__(self, num_robots: int, config: TeamFilterConfig) -> None:
        self._config = config
        self._mean = np.zeros(SIZE * num_robots)
        self._cov = np.zeros((self._mean.size, self._mean.size))
        self._gain = np.zeros(self._mean.size)

    def place(self, robot: int, estimate: PoseEstimate) -> None:
        """Set a robot's pose, unrelated to the others; its sensors' errors become the prior's."""
        self.place_jointly([robot], [], estimate.pose.as_array(), estimate.cov)

    def place_jointly(
        self, fresh: Sequence[int], held: Sequence[int], mean: np.ndarray, cov: np.ndarray
    ) -> None:
        """Set poses of robots from one answer for them and others, related as that answer says.

        Of the others, whose poses stay as they are, it counts where they are seen from `fresh`.

        Args:
            fresh: The robots to set; their sensors' errors become the prior's.
            held: Located robots that the answer has as well.
            mean: x, y, yaw of all of them, `fresh` first, (3 (F + H),).
            cov: Of that.
        """
        for robot in fresh:
            self._clear_with_prior(robot)
        new, old, num = _pose_rows(fresh), _pose_rows(held), 3 * len(fresh)
        by_held = np.linalg.solve(cov[num:, num:], cov[num:, :num]).T
        off = self._mean[old] - mean[num:]
        off[2::3] = (off[2::3] + np.pi) % (2.0 * np.pi) - np.pi
        self._mean[new] = mean[:num] + by_held @ off
        across = by_held @ self._cov[old]
        self._cov[new] += across
        self._cov[:, new] += across.T
        own = cov[:num, :num] - by_held @ cov[num:, :num] + across[:, old] @ by_held.T
        self._cov[np.ix_(new, new)] = 0.5 * (own + own.T)

    def _clear_with_prior(self, robot: int) -> None:
        config = self._config
        self.clear(robot)
        sds = [config.offset_sd_rad, config.scale_sd, config.travel_scale_sd]
        sds += [config.turn_scale_sd, config.curve_sd, config.drag_sd]
        for state, sd in zip((OFFSET, SCALE, TRAVEL, TURN, CURVE, DRAG), sds, strict=True):
            self._cov[robot * SIZE + state, robot * SIZE + state] = sd**2

    def clear(self, robot: int) -> None:
        """Drop all that is known of a robot."""
        rows = slice(robot * SIZE, (robot + 1) * SIZE)
        self._mean[rows], self._cov[rows, :], self._cov[:, rows] = 0.0, 0.0, 0.0

    def move(self, robot: int, motion: SE2, dt: float, cov: np.ndarray | None) -> None:
        """Move a robot by its odometry; `cov` (3, 3) is of the motion, None for the configured."""
        config = self._config
        way, turned = motion.distance, abs(motion.yaw)
        noise = motion_cov(way, turned, config) if cov is None else np.asarray(cov, float)
        walk = np.zeros(SIZE)
        walk[OFFSET] = config.offset_walk**2 * dt
        walk[[TRAVEL, CURVE]] = config.scale_walk**2 * way
        walk[TURN] = config.scale_walk**2 * turned
        rate = turned / dt if dt > 0.0 else 0.0
        predict_robot(self._mean, self._cov, robot, motion.as_array(), noise, walk, rate)

    def expect(self, robot: int, bearing: float, target: int | np.ndarray) -> tuple[float, float]:
        """Return measured less expected bearing and the variance of the expected one.

        Args:
            robot: Who sees.
            bearing: Measured, rad.
            target: Index of a robot, or a landmark's position, shape (2,).
        """
        number, point = NOT_A_ROBOT, target
        if isinstance(target, int):
            number, point = target, np.zeros(2)
        return look(self._mean, self._cov, robot, bearing, number, point, self._gain)

    def learn(
        self, robot: int, bearing: float, target: int | np.ndarray, noise: float
    ) -> tuple[float, bool]:
        """Correct the team by one bearing, unless it is out of the question.

        Args:
            robot: Who sees.
            bearing: Measured, rad.
            target: Index of a robot, or a landmark's position, shape (2,).
            noise: Variance of the bearing, rad^2.

        Returns:
            Squared deviation from what was expected, and whether the bearing was used.
        """
        off, var = self.expect(robot, bearing, target)
        if var < 0.0:
            return np.nan, False
        square = off * off / (var + noise)
        if square > self._config.gate_sd**2:
            return square, False
        soft = max(square / self._config.soft_sd**2, 1.0)
        learn(self._mean, self._cov, self._gain, off, var + noise * soft)
        return square, True

    def learn_pose(self, robot: int, estimate: PoseEstimate) -> bool:
        """Correct the team by a robot's pose from another source; return whether it was used."""
        now, rows = self.pose(robot), _pose_rows([robot])
        if mahalanobis(now, estimate) > self._config.gate_sd**2:
            return False
        gain = np.linalg.solve(now.cov + estimate.cov, self._cov[rows]).T
        self._mean += gain @ difference(estimate.pose, now.pose)
        cov = self._cov - gain @ self._cov[rows]
        self._cov = 0.5 * (cov + cov.T)
        return True

    def pose(self, robot: int) -> PoseEstimate:
        """Return a robot's pose."""
        o = robot * SIZE
        x, y, yaw = self._mean[o : o + 3]
        return PoseEstimate(SE2(float(x), float(y), float(yaw)), self._cov[o : o + 3, o : o + 3])

    def position(self, robot: int) -> tuple[np.ndarray, float]:
        """Return a robot's position, shape (1, 2), and the mean variance of it, m^2."""
        o = robot * SIZE
        spread = 0.5 * (self._cov[o, o] + self._cov[o + 1, o + 1])
        return self._mean[o : o + 2].reshape(1, 2).copy(), float(spread)

    def direction(self, robot: int, bearing: float) -> tuple[float, float]:
        """Return the direction in the map of what a robot sees, rad, and its own variance."""
        o = robot * SIZE
        inside = (bearing - self._mean[o + OFFSET]) / (1.0 + self._mean[o + SCALE])
        var = self._cov[o + YAW, o + YAW] + self._cov[o + OFFSET, o + OFFSET]
        return float(self._mean[o + YAW] + inside), float(var)

    def errors(self, robot: int) -> SensorErrors:
        """Return what a robot's sensors do wrong, as estimated so far."""
        o = robot * SIZE
        return SensorErrors(*(float(value) for value in self._mean[o + OFFSET : o + SIZE]))


def _pose_rows(robots: Sequence[int]) -> np.ndarray:
    """Return the states that are x, y and yaw of robots, (3 N,)."""
    return (SIZE * np.array(robots, dtype=int)[:, None] + np.arange(3)).ravel()


def motion_cov(way: float, turned: float, config: TeamFilterConfig) -> np.ndarray:
    """Return the covariance (3, 3) of a motion, from its way (m) and turn (rad, not negative)."""
    along, across = config.travel_noise**2 * way, config.sideways_noise**2 * way
    yaw = config.turn_noise_way**2 * way + config.turn_noise**2 * turned
    return np.diag([along, across, yaw])
