"""Recorded people: interpolation by hand, regions, gaps, and files that are refused."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from sim_bridge.people.recorded import read_obsmat, tracks_of
from sim_bridge.people.schema import Recording
from sim_bridge.schema import WorldError

HOTEL = Path(__file__).parents[2].parent / "shared/data/pedestrians/seq_hotel/obsmat.txt.gz"


def _file(tmp_path: Path, *rows: tuple[float, float, float, float]) -> str:
    lines = [f"{f} {i} {x} 0 {y} 0 0 0\n" for f, i, x, y in rows]
    path = tmp_path / "obsmat.txt"
    path.write_text("".join(lines))
    return str(path)


def test_between_samples_people_are_in_between(tmp_path: Path) -> None:
    file = _file(tmp_path, (0, 1, 0.0, 0.0), (10, 1, 0.4, 0.0), (20, 1, 0.4, 0.8))
    (track,) = tracks_of(Recording(file=file))
    position, velocity, walked = track.at(0.2)
    assert np.allclose(position, [0.2, 0.0]) and np.allclose(velocity, [1.0, 0.0])
    position, velocity, walked = track.at(0.7)
    assert np.allclose(position, [0.4, 0.6]) and np.allclose(velocity, [0.0, 2.0])
    assert walked == pytest.approx(1.0)
    assert track.at(0.81) is None and track.at(-0.01) is None


def test_start_time_and_pose_move_the_recording(tmp_path: Path) -> None:
    file = _file(tmp_path, (25, 1, 1.0, 0.0), (35, 1, 2.0, 0.0))
    recording = Recording(file=file, starts_s=1.0, position_m=(10.0, 0.0), yaw_deg=90.0)
    (track,) = tracks_of(recording)
    assert track.times[0] == pytest.approx(0.0)
    assert np.allclose(track.points, [[10.0, 1.0], [10.0, 2.0]])


def test_outside_the_region_nobody_is_there(tmp_path: Path) -> None:
    rows = [(10 * k, 1, float(x), 0.0) for k, x in enumerate([0, 1, 2, 9, 9, 2, 1, 0])]
    tracks = tracks_of(Recording(file=_file(tmp_path, *rows), low_m=(-1, -1), high_m=(5, 5)))
    assert [len(track.times) for track in tracks] == [3, 3]
    assert [track.slot for track in tracks] == [0, 0]


def test_people_at_the_same_time_have_bodies_of_their_own(tmp_path: Path) -> None:
    rows = [(0, 1, 0, 0), (10, 1, 1, 0), (0, 2, 0, 3), (10, 2, 1, 3), (20, 3, 0, 0), (30, 3, 1, 0)]
    tracks = tracks_of(Recording(file=_file(tmp_path, *rows)))
    assert [(track.number, track.slot) for track in tracks] == [(1, 0), (2, 1), (3, 0)]


def test_a_long_gap_parts_a_track(tmp_path: Path) -> None:
    rows = [(0, 1, 0, 0), (10, 1, 1, 0), (100, 1, 8, 0), (110, 1, 9, 0)]
    assert len(tracks_of(Recording(file=_file(tmp_path, *rows)))) == 2


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"1 2 3\n", "line 1: expected 8"),
        (b"1 1 0 0 0 0 0 0\n1 2 nan 0 0 0 0 0\n", "line 2"),
        (b"\n", "holds no rows"),
        (gzip.compress(b"1 1 0 0 0 0 0 0\n", mtime=0)[:-9], "not text"),
        (b"\xff\xfe\x00", "not text"),
    ],
)
def test_a_bad_file_is_one_clear_line(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "obsmat.txt"
    path.write_bytes(data)
    with pytest.raises(WorldError, match=words) as caught:
        read_obsmat(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named() -> None:
    with pytest.raises(WorldError, match="no/such.txt: No such file"):
        tracks_of(Recording(file="no/such.txt"))


@pytest.mark.skipif(not HOTEL.exists(), reason="the recordings are not here")
def test_the_hotel_holds_390_people_who_walk_at_1_27_m_s() -> None:
    tracks = tracks_of(Recording(file=str(HOTEL)))
    assert len({track.number for track in tracks}) == pytest.approx(390, abs=5)
    speeds = np.concatenate([np.diff(track.walked) / np.diff(track.times) for track in tracks])
    assert np.median(speeds) == pytest.approx(1.27, abs=0.02)
