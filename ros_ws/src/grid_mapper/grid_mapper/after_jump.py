"""Where a robot may be after time or odometry jumped, and when it counts as found there.

Guesses are the newest pose and the first one (a recording that starts again). One scan that fits
says little, for like places fit too: the robot is found where scans go on to fit over `WAY_M`, each
where the one before and odometry expect it, and no other guess fits as well by then. Where odometry
alone was set anew the robot cannot have gone far: near the newest pose one scan is enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.match_verdict import is_found
from grid_mapper.scan_matcher import MatchResult

WAY_M = 0.5
AGREE_M, AGREE_RAD, AGREE_SHARE = 0.05, 0.05, 0.2
"""How far a fit may be from where it was expected, and that for each m or rad moved."""
SAME_M = 0.3


@dataclass(frozen=True)
class Guess:
    """Where the robot may be now.

    Attributes:
        pose: There.
        way_m: Along which scans have to fit before it is believed.
        fits_since: Where they began to; None while they do not.
    """

    pose: SE2
    way_m: float = WAY_M
    fits_since: SE2 | None = None


def looked_at(
    guess: Guess, match: MatchResult, moved: SE2, has_odom: bool, config: GridMapperConfig
) -> Guess:
    """Return a guess after a scan.

    Args:
        guess: Before the scan.
        match: Of the scan, near the guess moved on.
        moved: Motion since the guess.
        has_odom: Whether odometry says so; else only that it fits counts.
        config: What a fit is.
    """
    expected, pose = guess.pose @ moved, match.T_map_base
    if not is_found(match, config):
        return replace(guess, pose=expected, fits_since=None)
    off = expected.between(pose)
    slack_m = AGREE_M + AGREE_SHARE * moved.distance
    slack_rad = AGREE_RAD + AGREE_SHARE * abs(moved.yaw)
    is_expected = off.distance <= slack_m and abs(off.yaw) <= slack_rad
    if guess.fits_since is None or (has_odom and not is_expected):
        return replace(guess, pose=pose, fits_since=pose)
    return replace(guess, pose=pose)


def settled(guesses: Sequence[Guess]) -> int | None:
    """Return the number of the guess that is right; None while that is not known."""
    fitting = [k for k, guess in enumerate(guesses) if guess.fits_since is not None]
    done = [k for k in fitting if _way(guesses[k]) >= guesses[k].way_m]
    if not done:
        return None
    best = min(done, key=lambda k: guesses[k].way_m)
    at = guesses[best].pose
    is_only = all(at.between(guesses[k].pose).distance < SAME_M for k in fitting)
    return best if is_only or guesses[best].way_m == 0.0 else None


def _way(guess: Guess) -> float:
    """Return how far the robot came while scans fitted, m."""
    return 0.0 if guess.fits_since is None else guess.fits_since.between(guess.pose).distance
