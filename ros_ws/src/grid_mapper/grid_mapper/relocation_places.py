"""Places in a map where a lost robot may be, and how well its looks fit there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.correlative_search import is_same_peak
from grid_mapper.relocation_config import RelocationConfig
from grid_mapper.scan_matcher import MatchResult

MAX_PLACES = 40
MIN_QUALITY = 0.05


@dataclass(frozen=True)
class PlaceFit:
    """How one look fits at a place: its pose there, overlap times agreement, and so on."""

    match: MatchResult
    contradiction: float

    @property
    def quality(self) -> float:
        """How well it fits, 0..1."""
        return self.match.overlap * self.match.agreement * (1.0 - self.contradiction)


@dataclass(frozen=True)
class Place:
    """Where the robot may be: its pose at the newest look, and the fits of all looks."""

    pose: SE2
    fits: tuple[PlaceFit, ...]

    @property
    def log_quality(self) -> float:
        """Of all looks together: each counts by itself, so one that does not fit is enough."""
        return float(np.sum(np.log([max(fit.quality, MIN_QUALITY) for fit in self.fits])))


def distinct(places: list[Place], share: float) -> list[Place]:
    """Return places, the best first, none near a better one or far worse than the best."""
    kept: list[Place] = []
    for place in sorted(places, key=lambda place: -place.log_quality):
        if kept and place.log_quality < kept[0].log_quality + np.log(share):
            break
        if all(not is_same_peak(place.pose, other.pose) for other in kept):
            kept.append(place)
    return kept[:MAX_PLACES]


def misfit(place: Place, config: RelocationConfig) -> str:
    """Return why looks do not fit at a place; "" if they do."""
    matches = [fit.match for fit in place.fits]
    overlap = float(np.mean([m.overlap for m in matches]))
    agreement = float(np.mean([m.agreement for m in matches]))
    through = float(np.mean([fit.contradiction for fit in place.fits]))
    if min(overlap, matches[0].overlap + 0.1) < config.min_overlap:
        return f"at best {100 * overlap:.0f} % of the scan fits the map"
    if min(agreement, matches[0].agreement + 0.1) < config.min_agreement:
        return f"what is near the map does not lie on it: agreement {agreement:.2f}"
    if through > config.max_contradiction:
        return f"{100 * through:.0f} % of the map's walls are seen through"
    return ""


def largest_sigma(cov: np.ndarray) -> float:
    """Return the deviation of a position in its least certain direction, m."""
    return float(np.sqrt(np.linalg.eigvalsh(cov[:2, :2]).max()))
