import json
import zipfile
from collections import Counter, deque
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from loop_builders import drifted, ring, round_the_ring
from worlds import scan_at

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.recordings.events import RangeEvent, Recording, ScanEvent
from grid_mapper.session_codec import kept, packed, unpacked
from grid_mapper.session_files import (
    KINDS,
    LEFT_OUT,
    VERSION,
    SessionError,
    load_session,
    save_session,
)
from grid_mapper.session_run import first_scans, num_taken, rest_of, take_up, together

STEP_NS = 300_000_000
HERE = SE2.identity()
CONFIG = GridMapperConfig(loop=replace(GridMapperConfig().loop, recent_scans=20))
CUT = 95
LAYOUT = Path(__file__).parents[1] / "data" / "session_layout.txt"


@pytest.fixture(scope="module")
def events():
    """A lap and a quarter round the ring, with a sonar's reading behind every scan."""
    truth, rng = round_the_ring(125, 1.25), np.random.default_rng(1)
    odometry = drifted(truth, 0.001, 1.02)
    found = []
    for k, (pose, odom) in enumerate(zip(truth, odometry, strict=True)):
        found.append(ScanEvent(k * STEP_NS, scan_at(pose, ring(), rng=rng), HERE, odom))
        found.append(RangeEvent(k * STEP_NS + 1, "sonar", 1.0, 0.1, 4.0, 0.3, HERE, odom))
    return found


def follow(localizer, events):
    for event in events:
        if isinstance(event, ScanEvent):
            seen = (event.stamp_ns, event.scan, event.T_base_laser, event.T_odom_base)
            if event.follows_jump:
                localizer.break_motion()
            localizer.insert_scan(*seen)
    return localizer


def recording(events):
    return Recording("test", [], lambda _: iter(events))


def bits(localizer):
    localizer.closer.finish()
    return [known.T_map_base.as_array().tobytes() for known in localizer.known_poses()]


@pytest.fixture
def saved(events, tmp_path):
    path = tmp_path / "drive.session"
    save_session(path, follow(LoopClosingLocalizer(CONFIG), events[:CUT]), events[:CUT])
    return path


def test_going_on_gives_to_the_bit_what_one_run_gives(events, saved):
    whole = follow(LoopClosingLocalizer(CONFIG), events)
    session = load_session(saved, CONFIG)
    assert num_taken(session, recording(events)) == CUT
    taken_up = follow(session.localizer(), rest_of(recording(events), CUT).events())
    assert taken_up.closer.num_loops == whole.closer.num_loops > 0
    assert bits(taken_up) == bits(whole)


def test_a_session_holds_all_events_that_were_taken(events, saved):
    session = load_session(saved, CONFIG)
    assert session.num_scans == (CUT + 1) // 2
    rest = rest_of(recording(events), CUT)
    assert packed(list(together(session, rest).events())) == packed(events)


def test_the_same_session_gives_the_same_bytes(events, saved, tmp_path):
    again = tmp_path / "again.session"
    session = load_session(saved, CONFIG)
    save_session(again, session.localizer(), session.events())
    assert again.read_bytes() == saved.read_bytes()


def test_another_recording_begins_with_a_jump(events, saved):
    late = [replace(event, stamp_ns=event.stamp_ns + 10**12) for event in events]
    session = load_session(saved, CONFIG)
    assert num_taken(session, recording(late)) is None
    jumps = [e.follows_jump for e in rest_of(recording(late), None).events()
             if isinstance(e, ScanEvent)]  # fmt: skip
    assert jumps == [True] + [False] * (len(jumps) - 1)


def test_another_recording_may_begin_at_any_time(events, saved):
    other = [replace(event, stamp_ns=event.stamp_ns + 3) for event in events]
    taken_up = take_up(load_session(saved, CONFIG), recording(other))
    assert taken_up.taken is None
    scans = [e for e in taken_up.all(recording(other)).events() if isinstance(e, ScanEvent)]
    num_before = taken_up.session.num_scans
    assert len(scans) == num_before + len(events) // 2
    assert [k for k, e in enumerate(scans) if e.follows_jump] == [num_before]
    assert scans[num_before].stamp_ns == 3 < scans[num_before - 1].stamp_ns


def test_readings_before_the_first_scan_of_another_recording_are_left_out(events, saved):
    late = [replace(event, stamp_ns=event.stamp_ns + 10**12) for event in events[1:]]
    assert isinstance(late[0], RangeEvent)
    rest = list(rest_of(recording(late), None).events())
    assert isinstance(rest[0], ScanEvent) and len(rest) == len(late) - 1


def test_a_recording_that_was_taken_before_another_one_is_refused(events, tmp_path):
    later = [replace(event, stamp_ns=event.stamp_ns + 10**12) for event in events[:10]]
    path, both = tmp_path / "two.session", [*events[:20], *later]
    save_session(path, follow(LoopClosingLocalizer(CONFIG), both), both)
    session = load_session(path, CONFIG)
    with pytest.raises(SessionError, match="two.session holds this recording already"):
        num_taken(session, recording(events[:20]))
    assert num_taken(session, recording(later)) == 10
    assert num_taken(session, recording(events)) is None  # longer: there is more in it


def test_a_reading_without_a_value_is_known_again(events, tmp_path):
    silent = [events[0], replace(events[1], range=float("nan"))]
    path = tmp_path / "silent.session"
    save_session(path, follow(LoopClosingLocalizer(CONFIG), silent), silent)
    assert num_taken(load_session(path, CONFIG), recording(silent)) == 2


def test_the_first_scans_come_with_the_readings_behind_them(events):
    assert list(first_scans(recording(events), 3)) == events[:6]


@pytest.mark.parametrize("size", [0, 10, 5000, -1])
def test_a_file_that_is_cut_off_is_refused_in_one_line(saved, size):
    saved.write_bytes(saved.read_bytes()[:size])
    with pytest.raises(SessionError, match="no session of map_bag, or is cut off") as found:
        load_session(saved, CONFIG)
    assert "\n" not in str(found.value)


def test_a_flipped_bit_is_refused(saved):
    data = bytearray(saved.read_bytes())
    data[len(data) // 2] ^= 4
    saved.write_bytes(data)
    with pytest.raises(SessionError, match="damaged|cut off"):
        load_session(saved, CONFIG)


def test_a_foreign_zip_a_folder_and_nothing_are_refused(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("head", json.dumps({"format": "something else"}))
    for file, problem in (
        (path, "is no session"),
        (tmp_path, "Is a dir"),
        (tmp_path / "x", "No s"),
    ):
        with pytest.raises(SessionError, match=problem):
            load_session(file, CONFIG)


@pytest.mark.parametrize(
    "change",
    [
        lambda head: head.pop("config"),
        lambda head: head.update(config=["grid"]),
        lambda head: head.update(parts="two"),
        lambda head: head.update(parts=10**6),
        lambda head: head.pop("scans"),
    ],
)
def test_a_head_that_says_something_else_is_refused_in_one_line(saved, change):
    with zipfile.ZipFile(saved) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    head = json.loads(parts["head"])
    change(head)
    parts["head"] = json.dumps(head).encode()
    with zipfile.ZipFile(saved, "w") as archive:
        for name, data in parts.items():
            archive.writestr(name, data)
    with pytest.raises(SessionError, match="drive.session is damaged") as found:
        load_session(saved, CONFIG)
    assert "\n" not in str(found.value)


@pytest.mark.parametrize("events_saved", [[], [SE2.identity()], [np.zeros(3)]])
def test_what_is_no_event_is_refused_in_one_line(saved, events_saved):
    with zipfile.ZipFile(saved) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    (name,) = [name for name in parts if name.startswith("events")]
    parts[name] = packed(events_saved)
    with zipfile.ZipFile(saved, "w") as archive:
        for part, data in parts.items():
            archive.writestr(part, data)
    with pytest.raises(SessionError, match="drive.session is damaged") as found:
        load_session(saved, CONFIG)
    assert "\n" not in str(found.value)


def test_other_parameters_are_refused_by_name(saved):
    other = replace(CONFIG, loop=replace(CONFIG.loop, kernel=3.0))
    with pytest.raises(SessionError, match="was made with loop.kernel 2.0, which is 3.0 now"):
        load_session(saved, other)


def test_nothing_is_left_behind_where_saving_fails(tmp_path):
    with pytest.raises(ValueError, match="not one event"):
        save_session(tmp_path / "a.session", LoopClosingLocalizer(CONFIG), [])
    assert list(tmp_path.iterdir()) == []


@dataclass(frozen=True)
class Pair:
    a: object
    b: object


class Thing:
    def __init__(self, inner=None):
        self.inner, self.config, self.value = inner, 1, None


def test_values_come_back_as_they_were():
    value = {
        "f": [0.1, float("inf"), -0.0], "t": (1, None, "x"), "q": deque([True]),
        "c": Counter(a=2), "d": Pair(SE2(1.0, 2.0, 3.0), b=Pair(1, 2)), "n": np.float64(2.5),
        "a": np.array([[1.5, np.nan]]), "u": np.zeros((0, 2), np.uint8),
    }  # fmt: skip
    back = unpacked(packed(value), {"SE2": SE2, "Pair": Pair})
    for name in ("a", "u"):
        array, old = back.pop(name), value.pop(name)
        assert array.dtype == old.dtype and np.array_equal(array, old, equal_nan=True)
    assert repr(back) == repr(value).replace("np.float64(2.5)", "2.5")


def test_an_object_met_twice_is_one_again():
    thing = Thing(Thing())
    thing.again = thing.inner
    thing.inner.value = 7
    fresh = Thing(Thing())
    fresh.again = fresh.inner
    config = frozenset({"config"})
    unpacked(packed(thing, config), {}, fresh, config)
    assert fresh.inner.value == 7 and fresh.again is fresh.inner


@pytest.mark.parametrize("data", [b"", b"\x01", packed(Pair(1, 2)), packed(Thing())])
def test_what_is_not_known_is_not_made(data):
    with pytest.raises(ValueError, match="."):
        unpacked(data, {}, None)


@pytest.mark.parametrize(("change", "problem"), [
    (lambda thing: setattr(thing, "more", 1), "unknown .'more'."),
    (lambda thing: delattr(thing, "inner"), "missing .'inner'."),
])  # fmt: skip
def test_other_attributes_than_the_object_has_are_refused(change, problem):
    thing = Thing()
    change(thing)
    with pytest.raises(ValueError, match=problem):
        unpacked(packed(thing), {}, Thing())
    fresh = Thing()
    unpacked(packed(Thing(2), frozenset({"config"})), {}, fresh, frozenset({"config"}))
    assert (fresh.inner, fresh.config) == (2, 1)


def test_a_state_that_does_not_fit_is_one_line(saved, monkeypatch):
    monkeypatch.setattr(
        "grid_mapper.session_files.LoopClosingLocalizer", lambda config: Thing(config)
    )
    with pytest.raises(SessionError, match="drive.session is damaged: not readable") as found:
        load_session(saved, CONFIG).localizer()
    assert "\n" not in str(found.value)


def layout_lines(value, place="session"):
    """Yield a line for every class whose attributes are saved, objects within objects too."""
    if hasattr(value, "as_state"):
        yield f"{place} {type(value).__name__}: by itself"
        return
    names = sorted(kept(value, LEFT_OUT))
    yield f"{place} {type(value).__name__}: {' '.join(names)}"
    for name in names:
        inner = vars(value)[name]
        if type(inner).__module__.startswith("grid_mapper") and not is_dataclass(inner):
            yield from layout_lines(inner, f"{place}.{name}")


def test_the_layout_is_that_of_the_version():
    lines = [f"version {VERSION}", *layout_lines(LoopClosingLocalizer(CONFIG))]
    for kind in KINDS.values():
        lines.append(f"{kind.__name__}: {' '.join(f.name for f in fields(kind))}")
    pinned = LAYOUT.read_text().splitlines()
    assert lines == pinned, (
        f"what a session is made of has changed: raise VERSION in session_files.py, "
        f"and write these lines to {LAYOUT}:\n" + "\n".join(lines)
    )
