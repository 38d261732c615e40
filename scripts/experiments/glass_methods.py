"""One log through every way to map it: laser, sonar, the published overlay, bayes, a costmap layer.

Poses come from scan matching on drifting odometry, or are the true ones; scan matching is the same
whatever is made of the map, so it runs once and all rows see its poses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from experiments.glass_logs import GlassLog
from experiments.range_layer import RangeLayer
from floornav_common.grid import UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig, KeyScanConfig, LabelGridConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.mapper import GridMapper
from grid_mapper.overlay import EVEN, on_cells_of
from grid_mapper.pose_history import PoseHistory
from grid_mapper.recordings.events import RangeEvent, ScanEvent
from grid_mapper.sonar_config import SonarConfig, SonarKeyConfig

NAMES = ("overlay", "laser", "sonar", "bayes", "range_layer")
NUM_KEY_SCANS = 26
_MAX_GAP_NS = round(SonarConfig().max_pose_gap_s * 1e9)
_EVERY_SCAN = KeyScanConfig(distance_m=0.0, turn_rad=0.0, period_s=0.0)
_EVERY_READING = SonarKeyConfig(distance_m=0.0, turn_rad=0.0, period_s=0.0)
# Grid of 5 cm, tolerance 5 cm, alpha_L 0.5 deg, alpha_S 20 deg, P_L 4, P_S 4.5 / m^2 (7.1.2).
PUBLISHED = GridMapperConfig(
    label=LabelGridConfig(beam_angle_rad=np.deg2rad(0.5), no_return_free_m=0.0),
    sonar=SonarConfig(aperture_rad=np.deg2rad(20.0)),
)


@dataclass
class Track:
    """Where the robot was, as readings are placed by.

    Attributes:
        poses: Of the scans that were trusted; between them it is interpolated.
        errors_m: How far the pose of each scan is from the true one.
        num_untrusted: Scans whose match was refused.
    """

    poses: PoseHistory = field(default_factory=lambda: PoseHistory(10**6))
    errors_m: list[float] = field(default_factory=list)
    num_untrusted: int = 0


@dataclass(frozen=True)
class Mapped:
    """A row's result.

    Attributes:
        occupancy: The map to drive by.
        glass: What it says is glass; None where it says nothing of glass.
    """

    occupancy: OccupancyMap
    glass: OccupancyMap | None


@dataclass(frozen=True)
class Published:
    """One way to feed the published rule.

    Attributes:
        config: Of the mapper.
        num_stops: Take so many scans of the drive, evenly spaced; None leaves it to `map_key`.
        has_sonar_at_stops_only: Take one reading of each sonar at each of these and no others.
    """

    config: GridMapperConfig
    num_stops: int | None = None
    has_sonar_at_stops_only: bool = False

    def takes(self, log: GlassLog) -> Callable[[ScanEvent | RangeEvent], bool]:
        """Return what tells which events of a log are taken."""
        if self.num_stops is None:
            return lambda event: True
        chosen = np.linspace(0, len(log.scan_ns) - 1, self.num_stops).round().astype(int)
        stops = log.scan_ns[chosen]
        round_ns = int(np.diff(log.range_ns[log.range_sensor == 0][:2])[0])

        def takes(event: ScanEvent | RangeEvent) -> bool:
            if isinstance(event, ScanEvent):
                return event.stamp_ns in stops
            since = event.stamp_ns - stops
            return not self.has_sonar_at_stops_only or bool(
                ((since > -round_ns) & (since <= 0)).any()
            )

        return takes


def overlays_of(*, is_paper_world: bool) -> dict[str, Published]:
    """Return the published rule's rows: the paper's way first, then with other key scans.

    The paper counts 26 laser measurements and does not say how often its sonars fired; its maps
    show walls of echoes, not 26 groups of arcs. So the first row takes each sonar every 5 cm on the
    way; `overlay_sonar_at_stops_only` is the other reading. `all_rows` adds the one with the
    mapper's own spacing.
    """
    if not is_paper_world:
        key = KeyScanConfig(distance_m=1.0, turn_rad=6.0, period_s=7.5)  # as far as its stops
        return {"overlay": Published(replace(PUBLISHED, map_key=key))}
    every = replace(PUBLISHED, map_key=_EVERY_SCAN)
    whole = replace(every, sonar_key=_EVERY_READING)
    return {
        "overlay": Published(every, NUM_KEY_SCANS),
        "overlay_sonar_at_stops_only": Published(whole, NUM_KEY_SCANS, True),
        "overlay_all_scans": Published(whole),
    }


def localized(log: GlassLog, start: SE2 | None = None) -> Track:
    """Return the poses that scan matching on drifting odometry gives.

    Args:
        log: The drive.
        start: First pose; the true one by default. From another one on, errors mean nothing.
    """
    track, mapper = Track(), GridMapper(GridMapperConfig(), log.start if start is None else start)
    for event, T_true in log.events():
        if isinstance(event, ScanEvent):
            result = mapper.insert_scan(
                event.stamp_ns, event.scan, event.T_base_laser, event.T_odom_base
            )
            track.errors_m.append(T_true.between(result.T_map_base).distance)
            track.num_untrusted += not result.is_trusted
            if result.is_trusted:
                track.poses.add(event.stamp_ns, result.T_map_base)
    return track


def true_track(log: GlassLog) -> Track:
    """Return the true poses."""
    track = Track(errors_m=[0.0] * len(log.scan_ns))
    for stamp_ns, pose in zip(log.scan_ns.tolist(), log.scan_true.tolist(), strict=True):
        track.poses.add(stamp_ns, SE2(*pose))
    return track


def placed(log: GlassLog, track: Track) -> Iterator[tuple[ScanEvent | RangeEvent, SE2]]:
    """Yield what could be placed, in time order, with the robot's pose by a track."""
    for event, _ in log.events():
        max_gap_ns = _MAX_GAP_NS if isinstance(event, RangeEvent) else 0
        pose = track.poses.at(event.stamp_ns, max_gap_ns)
        if pose is not None:
            yield event, pose


def mapped(
    log: GlassLog,
    config: GridMapperConfig,
    track: Track,
    takes: Callable[[ScanEvent | RangeEvent], bool] = lambda event: True,
) -> LayeredMapper:
    """Return the mapper after a whole log, everything placed by a track.

    Args:
        log: The drive.
        config: Of the mapper.
        track: Where the robot was.
        takes: Tells which events are taken; all by default.

    Raises:
        ValueError: This version does not have `config.fusion`.
    """
    mapper = LayeredMapper(config, log.start)
    for event, pose in placed(log, track):
        if not takes(event):
            continue
        if isinstance(event, ScanEvent):
            mapper.place_scan(event.stamp_ns, event.scan, event.T_base_laser, pose)
        else:
            mapper.place_range(event.stamp_ns, event.reading, event.T_base_sonar, event.frame, pose)
    return mapper


def all_rows(
    log: GlassLog, overlays: Mapping[str, Published], track: Track
) -> dict[str, Mapped | None]:
    """Return the map of every row; None for a method that this version does not have.

    Args:
        log: The drive.
        overlays: The published rule by name of the row.
        track: Places everything.
    """
    rows = compared_rows(log, overlays, track)
    layers = mapped(log, GridMapperConfig(), track).layers()
    layer = RangeLayer(layers.laser)
    for event, pose in placed(log, track):
        if isinstance(event, RangeEvent):
            layer.add_range(event.reading, pose @ event.T_base_sonar)
    costmap = layer.combined(layers.laser)
    bayes = rows.pop("bayes")
    return {
        **rows,
        "laser": Mapped(layers.laser, None),
        "sonar": Mapped(layers.sonar, None),
        "bayes": bayes,
        "range_layer": Mapped(costmap, beyond(costmap, layers.laser)),
    }


def compared_rows(
    log: GlassLog, overlays: Mapping[str, Published], track: Track
) -> dict[str, Mapped]:
    """Return the published rule's rows and that of `bayes`."""
    rows = {
        name: row_of(mapped(log, rule.config, track, rule.takes(log)))
        for name, rule in overlays.items()
    }
    return {**rows, "bayes": _bayes_row(log, track)}


def row_of(mapper: LayeredMapper) -> Mapped:
    """Return what a mapper has as a row."""
    layers = mapper.layers()
    return Mapped(layers.occupancy, layers.glass)


def _bayes_row(log: GlassLog, track: Track) -> Mapped:
    return row_of(mapped(log, GridMapperConfig(fusion="bayes"), track))


def beyond(occupancy: OccupancyMap, laser: OccupancyMap) -> OccupancyMap:
    """Return what a map holds for an obstacle beyond the laser's map: occupied, else unknown."""
    is_more = (occupancy.cells >= EVEN) & (on_cells_of(laser, occupancy) < EVEN)
    cells = np.where(is_more, np.int8(100), np.int8(UNKNOWN))
    return OccupancyMap(cells, occupancy.resolution, occupancy.origin)
