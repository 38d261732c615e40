"""Storage files as crashes, tools and other distributions leave them."""

import gzip
import shutil
import sqlite3

import numpy as np
import pytest
from recording_builders import (
    NS,
    START_NS,
    drive,
    range_message,
    storage_file,
    tf_message,
    transform,
    write_bag,
    write_ros1_bag,
)

from floornav_common.se2 import SE2
from grid_mapper.recordings import RecordingError, RecordingOptions, open_recording
from grid_mapper.recordings.bag import Bag


def read(path, **options):
    recording = open_recording(path, RecordingOptions(**options))
    return recording, list(recording.events())


def split_bag(tmp_path, storage, compression=""):
    """Write one drive as three storage files in a folder, as `--max-bag-size` does."""
    messages, folder = drive(40), tmp_path / "split"
    folder.mkdir()
    parts = [messages[:30], messages[30:60], messages[60:]]
    for i, part in enumerate(parts):
        file = storage_file(write_bag(tmp_path / f"part{i}", part, storage, compression))
        shutil.copy(file, folder / f"split_{i}{''.join(file.suffixes)}")
    names = "".join(f"  - {f.name}\n" for f in sorted(folder.iterdir()))
    text = f"rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:\n{names}"
    (folder / "metadata.yaml").write_text(text)
    return folder


def leave_in_wal(bag):
    """Return a copy of a bag whose messages are all in the -wal file, as after a crash."""
    database = sqlite3.connect(storage_file(bag))
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA wal_autocheckpoint=0")
    rows = database.execute("SELECT topic_id, timestamp, data FROM messages").fetchall()
    database.execute("DELETE FROM messages")
    database.commit()
    database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", rows)
    database.commit()
    copy = shutil.copytree(bag, bag.with_name(bag.name + "-crashed"))
    database.close()
    return copy


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("compression", ["", "message", "file"])
def test_a_split_bag_is_one_recording(tmp_path, storage, compression):
    recording, events = read(split_bag(tmp_path, storage, compression))
    assert [e.stamp_ns for e in events] == [START_NS + i * NS // 10 for i in range(40)]
    assert recording.problem is None


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_split_bag_without_its_last_file_says_so(tmp_path, storage):
    folder = split_bag(tmp_path, storage)
    last = sorted(folder.glob("split_*"))[-1]
    last.write_bytes(b"")
    recording, events = read(folder)
    assert 20 < len(events) < 40
    assert f"{last.name} is empty" in recording.problem
    last.unlink()
    recording, _ = read(folder)
    assert "names 3 files, 2 are there" in recording.problem


@pytest.mark.parametrize(
    "text", ["rosbag2_bagfile_information:\n  version: 99\n", "\t: [", "", "7"]
)
def test_metadata_of_any_version_or_none_at_all_will_do(tmp_path, text):
    bag = write_bag(tmp_path / "bag", drive(5))
    (bag / "metadata.yaml").write_text(text)
    recording, events = read(bag)
    assert len(events) == 5 and recording.problem is None


def test_what_a_killed_recorder_left_beside_the_database_is_merged(tmp_path):
    crashed = leave_in_wal(write_bag(tmp_path / "bag", drive(40)))
    before = {f.name: f.read_bytes() for f in crashed.iterdir()}
    for file in crashed.iterdir():
        file.chmod(0o444)
    crashed.chmod(0o555)
    assert len(read(crashed)[1]) == 40
    assert len(read(storage_file(crashed))[1]) == 40
    assert {f.name: f.read_bytes() for f in crashed.iterdir()} == before
    crashed.chmod(0o755)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("name", ["with blanks", "a#b", "50%20", "what?", "[x]"])
def test_any_path_will_do(tmp_path, monkeypatch, storage, name):
    bag = write_bag(tmp_path / "bag", drive(5), storage).rename(tmp_path / name)
    monkeypatch.chdir(tmp_path)
    for path in (bag, f"./{name}/", storage_file(bag), bag / "metadata.yaml"):
        recording, events = read(path)
        assert len(events) == 5 and recording.problem is None


def test_a_folder_of_bags_or_logs_names_them(tmp_path):
    write_bag(tmp_path / "monday", drive(5))
    write_bag(tmp_path / "week" / "tuesday", drive(5))
    write_ros1_bag(tmp_path / "week" / "odom.bag", drive(1))
    (tmp_path / "no_bag").mkdir()
    names = "monday, week, week/tuesday"
    with pytest.raises(RecordingError, match=f"name one of the bags in it: {names}$"):
        read(tmp_path)
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "a.log").write_text("# of today\n\nFLASER\n")
    (tmp_path / "logs" / "a.relations").write_text("1.0 2.0 0.1 0 0 0 0 0.1\n")
    (tmp_path / "logs" / "b.gz").write_bytes(b"\x1f\x8bno")
    (tmp_path / "logs" / "c.log").write_text("VERTEX2 0 0 0 0\n")
    with pytest.raises(RecordingError, match=r"if it is a log: a\.log, c\.log$"):
        read(tmp_path / "logs")


@pytest.mark.parametrize("name", ["a.log", "a.log.gz"])
def test_a_text_log_opened_as_a_bag_names_what_maps_it(tmp_path, name):
    text = b"FLASER 1 1.0 0 0 0 0 0 0 1 host 1\n"
    (tmp_path / name).write_bytes(gzip.compress(text) if name.endswith(".gz") else text)
    with pytest.raises(RecordingError, match="text logs cannot be replayed, map them with map_bag"):
        Bag(tmp_path / name)


def ros1_parts(folder, *names):
    """Write one drive to several files, five scans each."""
    folder.mkdir()
    for i, name in enumerate(names):
        write_ros1_bag(folder / name, drive(5, START_NS + i * NS // 2))
    return folder


@pytest.mark.parametrize(
    "names",
    [("a_0.bag", "a_1.bag"), ("a_0.bag", "a_1.bag", "a_2.bag"),
     ("2024-05-01-10-00-00_0.bag", "2024-05-01-10-05-00_1.bag"),
     ("r_2024-05-01-10-00-00_9.bag", "r_2024-05-01-10-05-00_10.bag")],
)  # fmt: skip
def test_numbered_files_of_one_name_are_one_recording(tmp_path, names):
    _, events = read(ros1_parts(tmp_path / "bag", *names))
    assert len(events) == 5 * len(names)


@pytest.mark.parametrize(
    "names",
    [("odom.bag", "scan.bag"), ("a_0.bag", "b_1.bag"), ("a_0.bag", "a_2.bag"),
     ("run_1.bag", "run_2.bag"),
     ("2024-05-01-10-00-00.bag", "2024-05-01-10-05-00.bag")],
)  # fmt: skip
def test_a_folder_of_separate_files_is_not_joined(tmp_path, names):
    with pytest.raises(RecordingError, match=f"several bags: name one.*: {', '.join(names)}$"):
        read(ros1_parts(tmp_path / "bag", *names))


def test_of_several_files_those_that_metadata_lists_are_the_bag(tmp_path):
    bag = write_bag(tmp_path / "bag", drive(5))
    shutil.copyfile(storage_file(bag), bag / "copy.db3")
    recording, events = read(bag)
    assert len(events) == 5 and recording.problem is None


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_damage_in_the_middle_is_said_and_what_is_before_it_is_read(tmp_path, storage):
    bag = write_bag(tmp_path / "bag", drive(2000), storage)
    content = bytearray(storage_file(bag).read_bytes())
    middle = len(content) // 2
    content[middle : middle + 5000] = np.random.default_rng(0).bytes(5000)
    storage_file(bag).write_bytes(bytes(content))
    recording, events = read(bag)
    assert 500 < len(events) < 2000
    assert "damaged" in recording.problem and "last recorded at" in recording.problem


@pytest.mark.parametrize("compression", ["", "BZ2", "LZ4"])
def test_ros1_bags_are_read_whole_and_cut(tmp_path, compression):
    bag = write_ros1_bag(tmp_path / "whole.bag", drive(2000), compression)
    recording, events = read(bag)
    assert len(events) == 2000 and recording.problem is None
    content = bag.read_bytes()
    (tmp_path / "cut.bag").write_bytes(content[: len(content) // 2])
    recording, events = read(tmp_path / "cut.bag")
    assert 500 < len(events) <= 2000
    assert "cut off" in recording.problem and "('" not in recording.problem


@pytest.mark.parametrize("has_variance", [False, True])
def test_sonars_of_any_distribution_are_read_without_definitions(tmp_path, has_variance):
    sonar = [("/tf_static", 1, tf_message(transform(0, "base_link", "sonar_0")))]
    reading = ("/sonar", START_NS + 10, range_message(START_NS + 10, 0.5))
    bag = write_bag(tmp_path / "bag", [*sonar, *drive(5), reading])
    database = sqlite3.connect(storage_file(bag))
    if not has_variance:  # Range got it in Iron
        database.execute(
            "UPDATE messages SET data = substr(data, 1, length(data) - 4) WHERE topic_id ="
            " (SELECT id FROM topics WHERE name = '/sonar')"
        )
    for statement in ("DROP TABLE schema", "DROP TABLE message_definitions",
                      "ALTER TABLE topics DROP COLUMN type_description_hash"):  # fmt: skip
        database.execute(statement)
    database.commit()
    database.close()
    _, events = read(bag, sonar_topics=("/sonar",))
    assert len(events) == 6
    assert events[1].range == pytest.approx(0.5) and events[1].T_base_sonar == SE2.identity()
