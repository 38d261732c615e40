"""Finding a robot in a map that is there: from anywhere, or from about where it is said to be.

Every look (a scan taken apart from the last) is searched for in the whole map, and what was found
before is moved on by odometry and fitted again: a place counts by how all looks of late fit there,
as seen from it by odometry. It is believed once two looks at least fit well, the map's walls are
not seen through, nothing in the map is left that fits about as well, and the looks, and the parts
of the newest, agree where they are in every direction. Until then the robot has to drive on: like
rooms differ somewhere, and furniture that was moved comes out of sight. Where somebody says about
where the robot is, one look is enough, and only what that allows is a rival; the whole map is
searched only when nothing there fits.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.correlative_search import Peak, find_peaks, is_same_peak
from grid_mapper.global_search import GlobalSearch
from grid_mapper.key_frames import KeyFrame
from grid_mapper.loop_verification import seen_through
from grid_mapper.map_surfaces import round_place
from grid_mapper.match_scatter import scatter_of
from grid_mapper.motion import odometry_motion, rotated
from grid_mapper.relocation_messages import Forget, Found, Look, NewMap, NotFound, Prior
from grid_mapper.relocation_places import (
    MAX_PLACES,
    Place,
    PlaceFit,
    distinct,
    largest_sigma,
    misfit,
)
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.surface_points import SurfacePoints, points_of

MAX_LOOKS = 6
SEARCH_SHARE = 0.7
"""Places where a look fits by this share of the best are fitted closely."""
STEP_ASIDE_M, SAME_M, SHARE_ASIDE = 0.3, 0.08, 0.9
"""A place a step aside, further than `SAME_M`, must not fit by this share as well."""
ASIDE = "fits about as well a little aside: drive on"
NOT_THERE = "the scan does not fit where the robot is said to be"
ENOUGH = 0.35
"""A place that fits all looks together by less than this share of the best is out."""
START_COV = np.diag([0.1, 0.1, 0.05]) ** 2
SURROUNDINGS_M = 15.0


class Relocalizer:
    """Looks for a robot; work for a `background.Worker`."""

    has_work = False

    def __init__(self, config: GridMapperConfig) -> None:
        self._config = config
        self._search: GlobalSearch | None = None
        self._forget()

    def take(self, message: Look | NewMap | Forget) -> Found | NotFound | None:
        """Take a map or a look; answer a look."""
        if isinstance(message, NewMap):
            self._search = GlobalSearch(message.grid)
            self._matcher = ScanMatcher(self._config.matcher)
            self._matcher.insert(self._search.surfaces, SE2.identity())
            self._forget()
            return None
        if isinstance(message, Forget):
            self._forget()
            return None
        return self._look(message)

    def work(self) -> None:
        """Do nothing: a look is answered at once."""

    def best_at_once(self, points: SurfacePoints, is_fitted: bool) -> SE2 | None:
        """Return where points fit best in the whole map, believed or not.

        Args:
            points: In the robot's frame.
            is_fitted: Whether to fit them there; else the pose of the search as it is.
        """
        peaks = self._search.find(points.points, 1.0, 1) if self._search is not None else []
        if not peaks or not is_fitted:
            return peaks[0].pose if peaks else None
        return self._matcher.match(points, peaks[0].pose, START_COV).T_map_base

    def _forget(self) -> None:
        self._looks: deque[tuple[Look, KeyFrame]] = deque(maxlen=MAX_LOOKS)
        self._places: list[Place] = []

    def _look(self, look: Look) -> Found | NotFound:
        if self._search is None:
            return NotFound(look.number, "there is no map yet")
        points = points_of(look.scan, look.T_base_laser, self._config.matcher)
        if len(points) < self._config.min_pairs:
            return NotFound(look.number, f"the scan has {len(points)} points")
        self._follow(look)
        frame = KeyFrame(0, SE2.identity(), np.zeros((3, 3)), points, look.scan, look.T_base_laser)
        self._looks.append((look, frame))
        self._places = [self._seen_again(place) for place in self._places]
        if look.prior is None:
            return self._look_anywhere(points, look)
        answer = self._look_near(points, look, look.prior)
        if answer is not None:
            return answer
        answer = self._look_anywhere(points, look)
        if isinstance(answer, NotFound):
            answer = NotFound(look.number, f"{NOT_THERE}; in the whole map: {answer.reason}")
        return answer

    def _look_near(
        self, points: SurfacePoints, look: Look, prior: Prior
    ) -> Found | NotFound | None:
        """Look where the robot is said to be; return None if the looks do not fit there."""
        near = self._surroundings(prior.T_map_base, prior.window[0]).points
        peaks = find_peaks(near, points.points, prior.T_map_base, prior.window, MAX_PLACES)
        there = [place for place in self._places if prior.has(place.pose)]
        places = [place for place in self._ranked(there, peaks) if prior.has(place.pose)]
        if not places or misfit(places[0], self._config.relocation):
            return None
        self._places = places
        return self._judged(points, look)

    def _look_anywhere(self, points: SurfacePoints, look: Look) -> Found | NotFound:
        """Look in the whole map."""
        assert self._search is not None
        peaks = self._search.find(points.points, SEARCH_SHARE, MAX_PLACES)
        self._places = self._ranked(self._places, peaks)
        return self._judged(points, look, self._config.relocation.way_m)

    def _ranked(self, places: list[Place], peaks: list[Peak]) -> list[Place]:
        """Return places and where peaks are, the best first, those out of the question left out."""
        poses = [place.pose for place in places]
        for peak in peaks:
            if all(not is_same_peak(peak.pose, other) for other in poses):
                poses.append(peak.pose)
        share = max(self._config.relocation.rival_share ** len(self._looks), ENOUGH)
        return distinct(places + [self._place(pose) for pose in poses[len(places) :]], share)

    def _judged(self, points: SurfacePoints, look: Look, way_m: float = 0.0) -> Found | NotFound:
        """Return the best place, if all speaks for it and looks were taken that far apart."""
        if not self._places:
            return NotFound(look.number, "the scan fits nowhere in the map")
        best = self._places[0]
        reason = self._objection(best, len(self._places) - 1, way_m)
        if not reason:
            best, is_clear = self._settled(best)
            reason = self._objection(best, 0, way_m) if is_clear else ASIDE
        return NotFound(look.number, reason) if reason else self._claim(look.number, points, best)

    def _claim(self, number: int, points: SurfacePoints, best: Place) -> Found | NotFound:
        """Return a place that all else speaks for, unless parts of the newest look tell others."""
        scatter = scatter_of(self._matcher, points, best.pose, START_COV)
        sigma = largest_sigma(scatter)
        if sigma > self._config.relocation.max_sigma_m:
            return NotFound(number, f"parts of the scan disagree ({sigma:.2f} m): drive on")
        seen = self._surroundings(best.pose)
        return Found(number, best.pose, self._cov(best) + scatter, seen)

    def _surroundings(self, pose: SE2, beside_m: float = 0.0) -> SurfacePoints:
        assert self._search is not None
        return round_place(self._search.surfaces, pose.x, pose.y, SURROUNDINGS_M + beside_m)

    def _follow(self, look: Look) -> None:
        """Move the places found before on by odometry."""
        if not self._looks:
            return
        moved = self._looks[-1][0].T_odom_base.between(look.T_odom_base)
        self._places = [Place(place.pose @ moved, place.fits) for place in self._places]

    def _seen_again(self, place: Place) -> Place:
        """Return a place with the newest look's fit there."""
        _, frame = self._looks[-1]
        fit = self._fit(frame, place.pose)
        return Place(fit.match.T_map_base, (fit, *place.fits)[: len(self._looks)])

    def _fit(self, frame: KeyFrame, pose: SE2) -> PlaceFit:
        match = self._matcher.match(frame.points, pose, START_COV)
        return PlaceFit(match, self._contradiction(frame, match.T_map_base))

    def _place(self, pose: SE2) -> Place:
        """Return how all looks of late fit if the newest was taken about here."""
        newest, fits = self._looks[-1][0], []
        refined = pose
        for look, frame in reversed(self._looks):
            fits.append(self._fit(frame, refined @ newest.T_odom_base.between(look.T_odom_base)))
            if look is newest:
                refined = fits[0].match.T_map_base
        return Place(refined, tuple(fits))

    def _settled(self, place: Place) -> tuple[Place, bool]:
        """Return the best of the places a step round this one, and whether no other is near it."""
        steps = (0.0, STEP_ASIDE_M, -STEP_ASIDE_M)
        places = [self._place(place.pose @ SE2(x, y, 0.0)) for x in steps for y in steps]
        best = max(places, key=lambda other: other.log_quality)
        is_clear = all(
            other.log_quality < best.log_quality + np.log(SHARE_ASIDE)
            for other in places
            if best.pose.between(other.pose).distance > SAME_M
        )
        return best, is_clear

    def _contradiction(self, frame: KeyFrame, pose: SE2) -> float:
        """Return the share of the map's walls that a scan sees through."""
        return seen_through(frame, self._surroundings(pose).moved(pose.inverse()))

    def _objection(self, best: Place, num_rivals: int, way_m: float) -> str:
        """Return why the best place is not believed; "" if it is."""
        config = self._config.relocation
        if reason := misfit(best, config):
            return reason
        if num_rivals:
            return f"fits about as well at {num_rivals} other places: drive on"
        sigma = largest_sigma(self._cov(best))
        if sigma > config.max_sigma_m:
            return f"the scans leave a direction open ({sigma:.2f} m): drive on"
        if self._disagreement(best) > config.agree_m:
            return "the looks do not agree on the place"
        if self._way() < way_m:
            return f"fits at one place; a second look {way_m:g} m on has to say so too"
        return ""

    def _disagreement(self, place: Place) -> float:
        """Return how far the two newest looks are from each other, less what odometry errs, m."""
        if len(self._looks) < 2:
            return 0.0
        driven = self._looks[-2][0].T_odom_base.between(self._looks[-1][0].T_odom_base)
        seen = place.fits[1].match.T_map_base.between(place.fits[0].match.T_map_base)
        slack = self._config.motion.slip * (driven.distance + abs(driven.yaw))
        return driven.between(seen).distance - slack

    def _way(self) -> float:
        """Return how far from the newest look another was taken, m."""
        newest = self._looks[-1][0].T_odom_base
        return max(newest.between(look.T_odom_base).distance for look, _ in self._looks)

    def _cov(self, place: Place) -> np.ndarray:
        """Return the covariance of a place: what its newest look's match says, and odometry."""
        information, newest = np.linalg.inv(np.diag([1.0, 1.0, 0.5])), self._looks[-1][0]
        pairs = zip(place.fits, reversed(self._looks), strict=True)
        for fit, (look, _) in pairs:
            moved = newest.T_odom_base.between(look.T_odom_base)
            drift = rotated(odometry_motion(moved, self._config.motion), fit.match.T_map_base.yaw)
            own = fit.match.information + 1e-3 * np.eye(3)
            information += np.linalg.inv(np.linalg.inv(own) + drift)
        return np.asarray(np.linalg.inv(information))
