"""Recording and replaying over real DDS, each in a process of its own."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from grid_mapper.recordings.bag import Bag, Message
from grid_mapper.recordings.bag_writer import BagWriter

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
REPLAY = SCRIPTS / "replay.py"
STORE = get_typestore(Stores.ROS2_JAZZY)
STRING = "std_msgs/msg/String"
NS = 1_000_000_000
START_NS = 5_000 * NS
BEST_EFFORT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1000)
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
NO_LIMIT = QosTime(9223372036, 854775807)
Start = Callable[..., Any]
Peer = Any


def offered(reliability: QosReliability, durability: QosDurability) -> Qos:
    """Return a profile as a recorder finds it: DDS tells neither history nor depth."""
    history, liveliness = QosHistory.UNKNOWN, QosLiveliness.AUTOMATIC
    return Qos(history, 0, reliability, durability, NO_LIMIT, NO_LIMIT, liveliness, NO_LIMIT, False)


QOS = {
    "/fast": offered(QosReliability.RELIABLE, QosDurability.VOLATILE),
    "/lossy": offered(QosReliability.BEST_EFFORT, QosDurability.VOLATILE),
    "/map": offered(QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL),
}


def string_bytes(text: str) -> bytes:
    return bytes(STORE.serialize_cdr(STORE.types[STRING](text), STRING))


def write_bag(path: Path, storage: str = "mcap") -> Path:
    """Write 1.5 s: /fast each 20 ms, /lossy irregularly, /map twice, a type nobody has."""
    writer = BagWriter(path, storage)
    for name, qos in QOS.items():
        writer.add_topic(name, STRING, [qos])
    writer.add_topic("/odd", "robot_msgs/msg/Odd", definition="uint8 x\n")
    times = [(START_NS + i * NS // 50, "/fast", f"fast {i}") for i in range(75)]
    times += [(START_NS + i * i * NS // 400, "/lossy", f"lossy {i}") for i in range(24)]
    times += [(START_NS + 1, "/map", "first map"), (START_NS + NS // 2, "/map", "second map")]
    for stamp_ns, topic, text in sorted(times):
        writer.write(topic, stamp_ns, string_bytes(text))
    writer.write("/odd", START_NS + 2, b"\x00\x01\x00\x00\x07")
    writer.close()
    return path


def contents(path: Path) -> list[Message]:
    with Bag(path) as bag:
        return list(bag.messages())


def of_topic(messages: list[Message], topic: str) -> list[Message]:
    return [m for m in messages if m.topic == topic]


def words_of(messages: list[Message]) -> list[str]:
    """Return the text of each String; its bytes may end in padding that DDS adds."""
    return [STORE.deserialize_cdr(m.data, STRING).data for m in messages]


def num_recorded(recorder: Any) -> int:
    """Return how many messages a recorder says it has; the first ones sent it may not hear."""
    return max((int(num) for num in re.findall(r"(\d+) messages", recorder.text)), default=0)


def texts(messages: list[Any]) -> list[str]:
    return [message.data for message in messages]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_what_is_replayed_is_recorded_the_same(tmp_path: Path, start: Start, storage: str) -> None:
    source, copy = write_bag(tmp_path / "source", storage), tmp_path / "copy"
    recorder = start(SCRIPTS / "record.py", *QOS, "--out", copy, "--storage", storage)
    recorder.wait_for("recording")
    replay = start(REPLAY, source, "--wait", "60")
    assert replay.wait_for_exit() == 0
    assert "robot_msgs/msg/Odd" in replay.text
    recorder.wait_for(" 101 messages")
    assert recorder.stop(signal.SIGINT) == 0
    before, after = contents(source), contents(copy)
    for topic in QOS:
        sent, got = of_topic(before, topic), of_topic(after, topic)
        assert words_of(got) == words_of(sent)
        times_ns = [message.recorded_ns for message in got]
        assert times_ns == sorted(times_ns)
    with Bag(copy) as bag:
        for topic, profile in QOS.items():
            assert [(q.reliability, q.durability) for q in bag.topics[topic].qos] == [
                (profile.reliability, profile.durability)
            ]


def test_nothing_is_sent_before_it_is_due(tmp_path: Path, start: Start, peer: Peer) -> None:
    source = write_bag(tmp_path / "source")
    start(REPLAY, source, "--topics", "/fast", "/map", "--start", "0.01", "--wait", "60")
    sent_ns: dict[str, int] = {}

    def on_message(msg: String, info: Any) -> None:
        sent_ns[msg.data] = info["source_timestamp"]

    peer.wait_for_publisher("/fast", "/map")
    peer.node.create_subscription(String, "/map", on_message, LATCHED)
    peer.node.create_subscription(String, "/fast", on_message, RELIABLE)
    peer.spin_until(lambda: {"fast 74", "first map", "second map"} <= set(sent_ns))
    began_ns = sent_ns.pop("first map")  # latched, from before the start: sent before it begins
    due_ns = {f"fast {i}": i * NS // 50 for i in range(75)} | {"second map": NS // 2}
    assert all(sent_ns[text] - began_ns >= due_ns[text] - NS // 100 for text in sent_ns)


def test_start_in_the_middle_brings_the_latched_messages_and_the_right_time(
    tmp_path: Path, start: Start, peer: Peer
) -> None:
    source = write_bag(tmp_path / "source")
    given = ("--topics", "/fast", "/map", "--start", "1.0", "--wait", "60")
    replay = start(REPLAY, source, *given)
    peer.wait_for_publisher("/clock", "/fast", "/map")
    clocks = peer.collect(Clock, "/clock", BEST_EFFORT)
    maps = peer.collect(String, "/map", LATCHED)
    fast = peer.collect(String, "/fast", RELIABLE)
    peer.spin_until(lambda: len(fast) >= 25 and maps)
    assert replay.wait_for_exit() == 0
    peer.spin(0.1)
    assert texts(maps) == ["second map"]
    assert texts(fast) == [f"fast {i}" for i in range(50, 75)]
    stamps = [c.clock.sec + c.clock.nanosec * 1e-9 for c in clocks]
    assert stamps == sorted(stamps)
    assert 5001.0 <= stamps[0] < stamps[-1] <= 5001.5


def test_topics_remap_duration_and_qos_are_obeyed(tmp_path: Path, start: Start, peer: Peer) -> None:
    source = write_bag(tmp_path / "source")
    (tmp_path / "qos.yaml").write_text("/fast: {reliability: best_effort, depth: 7}\n")
    maps = peer.collect(String, "/map", LATCHED)
    replay = start(
        REPLAY, source, "--topics", "/fast", "--remap", "/fast:=/other", "--rate", "0.5",
        "--duration", "0.5", "--qos", tmp_path / "qos.yaml", "--clock", "0", "--wait", "60",
    )  # fmt: skip
    peer.wait_for_publisher("/other")
    (info,) = peer.node.get_publishers_info_by_topic("/other")
    assert info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert peer.node.get_publishers_info_by_topic("/clock") == []
    other = peer.collect(String, "/other", BEST_EFFORT)
    peer.spin_until(lambda: replay.has_ended)
    peer.spin(0.1)
    assert replay.wait_for_exit() == 0
    heard = texts(other)
    assert heard and heard == [text for i in range(26) if (text := f"fast {i}") in heard]
    assert maps == []


def test_loop_starts_again_until_it_is_stopped(tmp_path: Path, start: Start, peer: Peer) -> None:
    source = write_bag(tmp_path / "source")
    (tmp_path / "qos.yaml").write_text("/fast: {depth: 1000}\n")
    given = ("--topics", "/fast", "--qos", tmp_path / "qos.yaml", "--rate", "5", "--wait", "60")
    replay = start(REPLAY, source, "--loop", *given)
    peer.wait_for_publisher("/clock", "/fast")
    clocks = peer.collect(Clock, "/clock", BEST_EFFORT)
    fast = peer.collect(String, "/fast", RELIABLE)
    peer.spin_until(lambda: texts(fast).count("fast 0") >= 3)
    assert replay.stop(signal.SIGINT) == 0
    assert texts(fast)[:150] == [f"fast {i}" for i in range(75)] * 2
    stamps = [c.clock.sec + c.clock.nanosec * 1e-9 for c in clocks]
    assert any(b < a for a, b in zip(stamps, stamps[1:], strict=False))


@pytest.mark.parametrize(
    ("args", "expected"),
    [(["missing"], "does not exist"), (["source", "--topics", "/left"], "/left"),
     (["source", "--remap", "/fast"], "A:=B"), (["source", "--start", "9"], "behind the end"),
     (["source", "--qos", "missing"], "missing"), (["source", "--topics", "/odd"], "no topic")],
)  # fmt: skip
def test_bad_usage_is_one_line(
    tmp_path: Path, start: Start, monkeypatch: pytest.MonkeyPatch, args: list[str], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "source")
    replay = start(REPLAY, *args, "--quiet")
    assert replay.wait_for_exit() == 2
    assert len(replay.lines) == 1 and expected in replay.lines[0]


def test_recording_nothing_leaves_nothing(tmp_path: Path, start: Start) -> None:
    recorder = start(
        SCRIPTS / "record.py", "/nobody", "--out", tmp_path / "bag", "--duration", "0.5"
    )
    assert recorder.wait_for_exit() == 1
    assert "nobody published /nobody" in recorder.text and "no message came" in recorder.text
    assert list(tmp_path.iterdir()) == []


def test_a_bag_that_exists_is_not_touched(tmp_path: Path, start: Start, peer: Peer) -> None:
    old = write_bag(tmp_path / "bag")
    before = contents(old)
    recorder = start(SCRIPTS / "record.py", "/words", "--out", old)
    publisher = peer.publisher(String, "/words", 10)
    peer.publish_until(publisher, String(data="hello"), lambda: num_recorded(recorder) >= 5)
    assert "exists" in recorder.text
    assert recorder.stop(signal.SIGINT) == 0
    assert contents(old) == before
    assert set(words_of(contents(tmp_path / "bag-2"))) == {"hello"}


def test_a_subscriber_whose_qos_does_not_fit_is_named_with_its_cure(
    tmp_path: Path, start: Start, peer: Peer
) -> None:
    source = write_bag(tmp_path / "source")
    peer.collect(String, "/lossy", RELIABLE)
    replay = start(REPLAY, source, "--loop", "--wait", "1")
    line = replay.wait_for("gets nothing of /lossy")
    assert "/test_peer" in line and "reliability: reliable" in line and "--qos" in line
    peer.spin(2.5)  # some more looks
    assert replay.stop(signal.SIGINT) == 0
    assert replay.text.count("gets nothing of") == 1


def test_a_clock_in_the_bag_is_not_published_beside_ours(
    tmp_path: Path, start: Start, peer: Peer
) -> None:
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/clock", "rosgraph_msgs/msg/Clock")
    writer.add_topic("/fast", STRING, [QOS["/fast"]])
    wrong = STORE.types["rosgraph_msgs/msg/Clock"](STORE.types["builtin_interfaces/msg/Time"](7, 0))
    for i in range(50):
        data = bytes(STORE.serialize_cdr(wrong, wrong.__msgtype__))
        writer.write("/clock", START_NS + i * NS // 50, data)
        writer.write("/fast", START_NS + i * NS // 50 + 1, string_bytes(f"fast {i}"))
    writer.close()
    replay = start(REPLAY, tmp_path / "bag", "--wait", "60", "--rate", "10")
    peer.wait_for_publisher("/clock", "/fast")
    clocks = peer.collect(Clock, "/clock", BEST_EFFORT)
    fast = peer.collect(String, "/fast", RELIABLE)
    peer.spin_until(lambda: "fast 49" in texts(fast))
    assert replay.wait_for_exit() == 0
    assert clocks and all(c.clock.sec >= START_NS // NS for c in clocks)
    assert "passed over: /clock" in replay.text


def test_a_topic_that_comes_late_is_recorded_from_then_on(
    tmp_path: Path, start: Start, peer: Peer
) -> None:
    recorder = start(SCRIPTS / "record.py", "/late", "/never", "--out", tmp_path / "bag")
    recorder.wait_for("recording")
    peer.spin(1.0)
    publisher = peer.publisher(String, "/late", BEST_EFFORT)
    sent: list[str] = []

    def has_recorded() -> bool:
        sent.append(f"late {len(sent)}")
        publisher.publish(String(data=sent[-1]))
        return num_recorded(recorder) >= 5

    peer.spin_until(has_recorded)
    assert recorder.stop(signal.SIGTERM) == 0
    words = words_of(contents(tmp_path / "bag"))
    assert len(words) >= 5 and words == [text for text in sent if text in words]
    assert "nobody published /never" in recorder.text
    with Bag(tmp_path / "bag") as bag:
        assert bag.topics["/late"].qos[0].reliability == QosReliability.BEST_EFFORT
