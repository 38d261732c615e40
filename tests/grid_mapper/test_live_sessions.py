"""Sessions of the live mapper: saved, taken up again, and what is refused."""

import errno
from dataclasses import replace

import numpy as np
import pytest
from loop_builders import drifted, ring, round_the_ring
from worlds import scan_at

from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper import session_files
from grid_mapper.background import InlineWorker
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig, LoopConfig
from grid_mapper.kept_archive import KeptArchive
from grid_mapper.kept_events import KeptScan
from grid_mapper.layers import LayeredMapper
from grid_mapper.live_sessions import kept_of, save_live
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_session import LoopSession
from grid_mapper.map_rebuild import MapRebuild
from grid_mapper.map_run import run_mapper
from grid_mapper.recordings.events import Recording, ScanEvent
from grid_mapper.session_codec import packed
from grid_mapper.session_files import SessionError, load_session
from grid_mapper.session_run import take_up

STEP_NS = 300_000_000
HERE = SE2.identity()
CONFIG = GridMapperConfig(loop=LoopConfig(recent_scans=20))
TRUTH = round_the_ring(170, 1.45)
CUT = 140
TOL_M = 0.12


def drive(mapper, first, end):
    """Drive a stretch with a sonar on the left; return errors (m) of the trusted poses."""
    odometry, errors = drifted(TRUTH, 0.002, 1.02), []
    start = odometry[first]  # its wheels count from zero in each sitting
    for k in range(first, end):
        rng = np.random.default_rng(k)
        scan, odom = scan_at(TRUTH[k], ring(), rng=rng), start.between(odometry[k])
        result = mapper.insert_scan(k * STEP_NS, scan, HERE, odom)
        heard = RangeReading(0.9, 0.3, 0.1, 3.0)
        mapper.insert_range(k * STEP_NS + 1, heard, SE2(0.0, 0.1, np.pi / 2.0), "sonar")
        if result.is_trusted:
            off = TRUTH[0].between(TRUTH[k]).between(result.T_map_base)
            errors.append(off.distance)
    return errors


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """Return a mapper that drove round the ring, its background, and its session's file."""
    path = tmp_path_factory.mktemp("live") / "ring.session"
    work = LoopSession(CONFIG)
    mapper = ClosingMapper(CONFIG, InlineWorker(work))
    drive(mapper, 0, CUT)
    mapper.link.save(str(path))
    mapper.take_news()
    assert mapper.link.saved.popleft().problem == ""
    return mapper, work, path


def taken_up(path):
    work = LoopSession(CONFIG, str(path))
    mapper = ClosingMapper(CONFIG, InlineWorker(work))
    mapper.take_up(load_session(path, CONFIG).localizer())
    return mapper, work


def test_the_graph_comes_back_as_it_was(driven):
    _, work, path = driven
    assert work._closer.num_loops > 0
    again = LoopSession(CONFIG, str(path))
    for name in ("frames", "poses", "edges"):
        assert packed(getattr(again._closer, name)) == packed(getattr(work._closer, name))


def test_what_maps_are_made_of_comes_back_as_it_was(driven):
    _, work, path = driven
    again = LoopSession(CONFIG, str(path))
    old, new = (list(w._archive.from_index(0, len(w._archive))) for w in (work, again))
    assert len(old) == len(new)
    for a, b in zip(old, new, strict=True):
        assert type(a) is type(b) and (a.stamp_ns, a.node) == (b.stamp_ns, b.node)
        assert a.T_local_base.between(b.T_local_base).distance < 1e-9
        if isinstance(a, KeptScan):
            assert np.array_equal(a.scan.ranges, b.scan.ranges, equal_nan=True)


def test_it_goes_on_in_the_same_map_with_the_same_graph(driven):
    before, work, path = driven
    mapper, again = taken_up(path)
    num, cells = len(work._closer.frames), before.layers().occupancy.cells
    errors = drive(mapper, CUT, 170)
    assert len(errors) > 15 and max(errors) < TOL_M
    assert mapper.num_swaps >= 1 and len(again._closer.frames) == mapper.node + 1 > num
    now = mapper.layers()
    assert (now.occupancy.cells == 100).sum() > 0.8 * (cells == 100).sum()
    assert now.sonar.cells.size > 0


def test_near_the_first_pose_it_is_found_too(driven):
    mapper, _ = taken_up(driven[2])
    errors = drive(mapper, 0, 25)
    assert len(errors) > 10 and max(errors) < TOL_M


def test_a_session_taken_up_is_saved_whole_again(driven, tmp_path):
    mapper, work = taken_up(driven[2])
    drive(mapper, CUT, 150)
    path = tmp_path / "second.session"
    mapper.link.save(str(path))
    mapper.take_news()
    assert mapper.link.saved.popleft().problem == ""
    third = LoopSession(CONFIG, str(path))
    assert len(third._archive) == len(work._archive)
    assert len(third._closer.frames) == len(work._closer.frames)


def test_a_full_disk_is_told_and_the_old_session_stays(driven, monkeypatch):
    mapper, _, path = driven
    old = path.read_bytes()

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(session_files, "_write", full)
    mapper.link.save(str(path))
    mapper.take_news()
    assert "No space left on device" in mapper.link.saved.popleft().problem
    assert path.read_bytes() == old and [p.name for p in path.parent.iterdir()] == [path.name]
    assert mapper.failure == ""


def test_a_session_of_nothing_is_not_saved(tmp_path):
    with pytest.raises(ValueError, match="not one scan was mapped"):
        save_live(tmp_path / "a.session", LoopCloser(CONFIG), KeptArchive())
    assert list(tmp_path.iterdir()) == []


def test_a_background_refuses_a_session_of_other_parameters(driven):
    with pytest.raises(SessionError, match="was made with loop.kernel"):
        LoopSession(replace(CONFIG, loop=replace(CONFIG.loop, kernel=3.0)), str(driven[2]))


def test_a_scan_that_was_not_trusted_is_left_out_with_the_readings_behind_it(driven):
    events = list(load_session(driven[2], CONFIG).events())
    scans = [k for k, event in enumerate(events) if isinstance(event, ScanEvent)]
    part = events[: scans[10]]
    all_kept = list(kept_of(part, [(HERE, 0, None)] * 10))
    assert len(all_kept) == len(part)
    followed = [None] * 5 + [(HERE, 0, None)] * 5
    assert len(list(kept_of(part, followed))) == len(part) - scans[5]


def test_map_bag_goes_on_with_it_too(driven):
    mapper, _, path = driven
    session = load_session(path, CONFIG)
    localizer = session.localizer()
    assert localizer.num_scans == session.num_scans
    odometry = drifted(TRUTH, 0.002, 1.02)
    more = [
        ScanEvent(k * STEP_NS, scan_at(TRUTH[k], ring()), HERE, odometry[CUT].between(odometry[k]))
        for k in range(CUT, 170)
    ]
    rest = take_up(session, Recording("test", [], lambda _: iter(more))).rest(
        Recording("test", [], lambda _: iter(more))
    )
    run_mapper(rest, localizer)
    localizer.leave_out_unplaced(session.num_scans)
    poses = localizer.known_poses()
    assert len(poses) > session.num_scans + 15
    off = TRUTH[0].between(TRUTH[-1]).between(poses[-1].T_map_base).distance
    assert poses[-1].is_trusted and off < TOL_M
    maps = LayeredMapper(CONFIG)
    again = Recording("test", [], lambda _: session.events())
    run_mapper(again, MapRebuild(maps, poses[: session.num_scans]))
    walls = (maps.layers().occupancy.cells == 100).sum()
    assert walls > 0.8 * (mapper.layers().occupancy.cells == 100).sum()
