"""The experiment glass-map on one small room: logs, rows, figures."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from experiments.glass_floors import Job, run_job, turned_back
from experiments.glass_logs import GlassLog, drive, load_log
from experiments.glass_map import path_sums, reached, spreads
from experiments.glass_measures import measured
from experiments.glass_methods import (
    NAMES,
    compared_rows,
    localized,
    mapped,
    overlays_of,
    true_track,
)
from experiments.glass_paths import INFLATION_M, pairs_behind_glass
from experiments.glass_truth import truth_of
from floornav_common.se2 import SE2
from grid_mapper.recordings.events import ScanEvent
from sim_bridge.measures import Measure

ROOM = """
name: room
walls:
  - {from_m: [-0.06, -0.06], to_m: [5.06, -0.06]}
  - {from_m: [5.06, -0.06], to_m: [5.06, 4.06]}
  - {from_m: [5.06, 4.06], to_m: [-0.06, 4.06]}
  - {from_m: [-0.06, 4.06], to_m: [-0.06, -0.06]}
  - {from_m: [0, 2.4], to_m: [5, 2.4], glass: {thickness_m: 0.008}, frame: {spacing_m: 1.25}}
robots:
  - {model: segway_rmp50, position_m: [0.8, 1.2]}
route: {waypoints_m: [[0.8, 1.2], [4.2, 1.3]]}
"""


@pytest.fixture(scope="module")
def room(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("glass") / "room.yaml"
    path.write_text(ROOM)
    return path


@pytest.fixture(scope="module")
def log(room: Path) -> GlassLog:
    return drive(room, 0, cache=room.parent / "logs")


def test_a_log_is_kept_and_read_again_as_it_was(room: Path, log: GlassLog) -> None:
    (path,) = (room.parent / "logs").iterdir()
    again = load_log(path)
    assert again is not None
    for field in fields(GlassLog):
        np.testing.assert_array_equal(getattr(again, field.name), getattr(log, field.name))


def test_a_log_that_is_kept_is_not_driven_again(room: Path, log: GlassLog) -> None:
    other = room.parent / "other"
    replace(log, num_touches=np.array(77)).save(_kept_as(room, other))
    assert drive(room, 0, cache=other).num_touches == 77
    assert drive(room, 1, cache=other).num_touches == 0


def test_a_file_of_another_version_is_no_log(tmp_path: Path) -> None:
    np.savez(tmp_path / "old.npz", format=0)
    assert load_log(tmp_path / "old.npz") is None
    assert load_log(tmp_path / "none.npz") is None


def test_a_drive_comes_to_its_end_and_its_odometry_drifts(log: GlassLog) -> None:
    assert log.is_complete
    assert log.num_touches == 0
    assert log.scan_true[-1, 0] > 4.0
    moved = log.scan_true[-1, :2] - log.scan_true[0, :2]
    off = log.scan_odom[-1, :2] - log.scan_odom[0, :2] - moved
    assert 1e-3 < np.hypot(*off) < 0.5


def test_events_come_in_the_order_of_their_stamps(log: GlassLog) -> None:
    events = [event for event, _ in log.events()]
    stamps = [event.stamp_ns for event in events]
    assert stamps == sorted(stamps)
    assert sum(isinstance(event, ScanEvent) for event in events) == len(log.scan_ns)
    assert len(events) == len(log.scan_ns) + len(log.range_ns)


def test_the_published_rows_take_26_key_scans_or_all(log: GlassLog) -> None:
    track, num_sonars = true_track(log), len(log.sonar_poses)
    found = {}
    for name, rule in overlays_of(is_paper_world=True).items():
        mapper = mapped(log, rule.config, track, rule.takes(log))
        found[name] = mapper.laser.num_key_scans, mapper.sonar_counts.placed
    readings = found["overlay_all_scans"][1]
    assert found["overlay_all_scans"][0] == len(log.scan_ns)
    assert found["overlay"] == (26, readings)
    # The first stop lies before the first reading's round has ended.
    assert found["overlay_sonar_at_stops_only"] == (26, pytest.approx(26 * num_sonars, abs=16))


def test_scan_matching_follows_the_robot(log: GlassLog) -> None:
    assert max(localized(log).errors_m) < 0.05


def test_every_row_is_judged_and_sonar_brings_the_glass(room: Path, log: GlassLog) -> None:
    result = run_job(Job(str(room), 0, room.parent / "logs", 6, 0, room.parent))
    assert set(NAMES) <= set(result["icp"])
    rows = result["icp"]
    assert rows["laser"]["glass_recall"] < 0.5
    assert rows["overlay"]["glass_recall"] > 0.9
    assert rows["range_layer"]["glass_recall"] > 0.6
    assert rows["laser"]["false_occupied"] < 0.002
    assert rows["laser"]["wall_error_m"] < 0.04
    assert all(Path(picture).stat().st_size > 0 for picture in result["pictures"])
    sums = path_sums([result], "paths")
    assert sums["laser"] is not None
    assert sums["laser"]["pairs"] == 6
    values = {"tables": [], "methods": spreads([result], "icp"), "paths": sums}
    assert reached(values)["lengths"] is None


def test_lengths_are_those_of_the_truth_on_turned_cells_too(room: Path, log: GlassLog) -> None:
    """From both lattices the wall behind the robot and the glass are as far apart as they are."""
    measure = Measure(name="a", from_m=(2.0, 0.0), to_m=(2.0, 2.396))
    solids = [s for s in log.solids() if s.is_at_height(float(log.laser_height))]
    rules = {"overlay": overlays_of(is_paper_world=True)["overlay"]}
    for turn in (SE2.identity(), SE2(0.0, 0.0, 0.3)):
        track = localized(log, turn @ log.start)
        for row in compared_rows(log, rules, track).values():
            back = turned_back(row, turn)
            assert abs(back.occupancy.origin.yaw) == pytest.approx(turn.yaw)
            found = measured(measure, solids, back.occupancy, back.glass)
            assert found == pytest.approx(2.396, abs=0.04)


def test_goals_behind_glass_are_free_and_seen_through_it(log: GlassLog) -> None:
    truth = truth_of(log)
    pairs = pairs_behind_glass(truth, 30, np.random.default_rng(0))
    assert pairs.shape == (30, 4)
    assert (pairs[:, 3] > 2.4).all() and (pairs[:, 1] < 2.4).all()
    cells = truth.lattice.to_cells(pairs[:, 2:])
    assert (truth.to_real[tuple(cells.T)] > INFLATION_M).all()
    nothing = replace(truth, is_behind=np.zeros_like(truth.is_behind))
    assert len(pairs_behind_glass(nothing, 30, np.random.default_rng(0))) == 0


def _kept_as(room: Path, folder: Path) -> Path:
    """Return where the log of seed 0 of a room would be kept."""
    folder.mkdir()
    (path,) = (room.parent / "logs").iterdir()
    return folder / path.name
