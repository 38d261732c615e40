"""A team on two hosts, over a cable that loses, delays and doubles what it carries."""

from __future__ import annotations

import os
import re
import shutil
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from node_process import NodeProcess
from team_scene import POSES, write_landmarks

from experiments.lossy_link import is_multicast, plan, without_checksum
from experiments.network_hosts import TwoHosts, why_not

HERE = Path(__file__).parent
NODE = (HERE / "listening.py", "multi_localizer.nodes.team_localizer_node")
TEAM = ("r1", "r2", "r3")
AHEAD_S = 0.7
BAD_LINE = ("--loss", "0.15", "--delay", "0.01", "--double", "0.2", "--seed", "1")
NEAR_M, FAR_M = 0.15, 0.5
FAR_OFF = 40.0  # chi-squared of 3 degrees: once in 10^8
NUM_LINES, LEAST_WHOLE, GOOD_SHARE = 60, 10, 0.8
NO_HOSTS = why_not()
if NO_HOSTS:  # pytest prints warnings, and reasons of skips only with -rs
    warnings.warn(f"NOT TESTED between separate hosts: {NO_HOSTS}", stacklevel=1)
needs_hosts = pytest.mark.skipif(
    bool(NO_HOSTS), reason=f"NOT TESTED between separate hosts: {NO_HOSTS}"
)
BIN = Path(sys.executable).parent
SERVER = shutil.which("fast-discovery-server", path=f"{BIN}:{os.environ['PATH']}")
"""What `fastdds discovery` runs."""


@pytest.fixture
def hosts() -> Iterator[TwoHosts]:
    made = TwoHosts()
    yield made
    made.remove()


@pytest.fixture
def run(hosts: TwoHosts, domain: int) -> Iterator[Callable[..., NodeProcess]]:
    """Return a function that starts a command; discovery reaches to the other host, no further."""
    env = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    started: list[NodeProcess] = []

    def _run(command: list[str], **more: str) -> NodeProcess:
        started.append(NodeProcess(command, env | more))
        return started[-1]

    yield _run
    for process in reversed(started):
        process.kill()


@pytest.fixture
def start_team(hosts: TwoHosts, run: Any, tmp_path: Path) -> Callable[..., Any]:
    """Return a function that starts the team; it returns what the cameras of both hosts print.

    Robots r1 and r3 are on one host, r2 on another; r3 runs no localizer.
    """
    place = write_landmarks(tmp_path)
    words = ("--ros-args", "-p", f"team:=[{', '.join(TEAM)}]", "-p", f"landmarks:={place}")

    def start(ahead_s: float, **more: str) -> tuple[NodeProcess, NodeProcess]:
        clock = ("-p", "use_sim_time:=true", "-r", "/clock:=/r2/clock") if ahead_s else ()
        nodes = [
            run(hosts.command("a", *NODE, *words, "-r", "__ns:=/r1"), **more),
            run(hosts.command("b", *NODE, *words, "-r", "__ns:=/r2", *clock), **more),
        ]
        cameras = (HERE / "team_cameras.py", "--team", *TEAM, "--ahead", str(ahead_s), "--names")
        near = run(hosts.command("a", *cameras[:-2], "0.0", "--names", "r1", "r3"), **more)
        far = run(hosts.command("b", *cameras, "r2"), **more)
        for node in nodes:
            node.wait_for("ready")
        return near, far

    return start


def numbers(line: str) -> list[float]:
    return [float(word) for word in re.findall(r"(?:nan|-?[0-9.]+(?:e-?[0-9]+)?)(?= |$)", line)]


def wait_for(process: NodeProcess, is_it: Callable[[str], bool], what: str) -> str:
    """Return the first line that is so."""
    end = time.monotonic() + 90.0
    while time.monotonic() < end:
        for line in list(process.lines):
            if is_it(line):
                return line
        time.sleep(0.1)
    pytest.fail(f"no {what}; last said:\n" + "\n".join(process.lines[-20:]))


def has_all(line: str) -> bool:
    """Whether a line of `team/poses` has every robot near where it is."""
    if not line.startswith("team/poses "):
        return False
    places = np.array(numbers(line)).reshape(-1, 2)
    true = np.array([[POSES[n].x, POSES[n].y] for n in TEAM])
    return places.shape == true.shape and bool(np.all(np.hypot(*(places - true).T) < NEAR_M))


def said(process: NodeProcess, start: str) -> list[str]:
    return [line for line in list(process.lines) if line.startswith(start)]


def after(process: NodeProcess, is_it: Callable[[str], bool]) -> list[str]:
    """Return the lines of `team/poses` from the first that is so."""
    lines = said(process, "team/poses ")
    first = next((k for k, line in enumerate(lines) if is_it(line)), len(lines))
    return lines[first:]


def is_far_off(line: str) -> bool:
    """Whether a line of `team/poses` has a robot where it is not; NaN says that nobody knows."""
    places = np.array(numbers(line)).reshape(-1, 2)
    true = np.array([[POSES[n].x, POSES[n].y] for n in TEAM])
    return bool(np.any(np.hypot(*(places - true).T) > FAR_M))


@needs_hosts
def test_a_team_on_two_hosts_over_a_bad_line_with_a_clock_that_is_wrong(
    hosts: TwoHosts, run: Any, start_team: Any
) -> None:
    """The clock of the second host is 0.7 s ahead."""
    link = run(hosts.link_command(*BAD_LINE))
    link.wait_for("linked")
    near, far = start_team(AHEAD_S)
    wait_for(near, has_all, "poses of all three on the first host")
    line = wait_for(
        near, lambda text: text.startswith("says r2 located") and "error (s)=0" in text,
        "offset of the other host's clock",
    )  # fmt: skip
    offset, error = (
        float(re.search(rf"{re.escape(key)}=(-?[0-9.]+);", line)[1])
        for key in ("clock offset (s)", "its error (s)")
    )
    assert abs(offset - AHEAD_S) <= error + 0.05 and error < 0.5
    wait_for(far, lambda text: text.startswith("team_pose"), "pose of r2")
    wait_for(near, lambda _: len(after(near, has_all)) >= NUM_LINES, f"{NUM_LINES} more poses")
    lines = after(near, has_all)
    assert not [line for line in lines if is_far_off(line)]
    whole = [line for line in lines if "nan" not in line]
    assert len(whole) >= LEAST_WHOLE
    assert np.mean([has_all(line) for line in whole]) >= GOOD_SHARE
    squares = [numbers(line)[3] for p in (near, far) for line in said(p, "team_pose ")]
    assert max(squares) < FAR_OFF
    lost, doubled = re.findall(r"lost (\d+), doubled (\d+)", link.text)[-1]
    assert int(lost) > 0 and int(doubled) > 0, "the line was to be bad"


@needs_hosts
@pytest.mark.skipif(SERVER is None, reason="NOT TESTED: no 'fast-discovery-server' is installed")
def test_without_multicast_a_discovery_server_introduces_the_hosts(
    hosts: TwoHosts, run: Any, start_team: Any
) -> None:
    run(hosts.link_command("--unicast")).wait_for("linked")
    address = hosts.ADDRESSES["a"]
    libraries = f"{BIN.parent / 'lib'}:{os.environ.get('LD_LIBRARY_PATH', '')}"
    server = [str(SERVER), "-i", "0", "-l", address, "-p", "11811"]
    run(hosts.join("a", server), LD_LIBRARY_PATH=libraries).wait_for("Server Addresses")
    near, _ = start_team(0.0, ROS_DISCOVERY_SERVER=f"{address}:11811")
    wait_for(near, has_all, "poses of all three on the first host")


def test_the_cable_loses_delays_and_doubles_by_its_seed() -> None:
    def draw() -> list[list[float]]:
        rng = np.random.default_rng(3)
        return [plan(rng, 0.2, 0.02, 0.3) for _ in range(4000)]

    plans = draw()
    assert plans == draw()
    counts = np.array([len(each) for each in plans])
    assert np.mean(counts == 0) == pytest.approx(0.2, abs=0.03)
    assert np.mean(counts == 2) == pytest.approx(0.8 * 0.3, abs=0.03)
    assert np.mean([d for each in plans for d in each]) == pytest.approx(0.02, rel=0.1)


def test_a_cable_without_multicast_still_carries_broadcasts() -> None:
    group, everyone, one = (bytes.fromhex(to) for to in ("01005e7fff01", "ffffffffffff", "0a" * 6))
    assert [is_multicast(to + bytes(40)) for to in (group, everyone, one)] == [True, False, False]


def test_only_the_checksum_of_udp_is_taken_out() -> None:
    header = bytes(12) + b"\x08\x00" + b"\x45" + bytes(5) + b"\x00\x00\x40\x11" + bytes(10)
    udp = b"\x1c\xe8\x1c\xe9\x00\x0a\xab\xcd"
    assert without_checksum(header + udp + b"hi") == header + udp[:6] + b"\x00\x00" + b"hi"
    other = header[:23] + b"\x06" + header[24:]
    fragment = header[:20] + b"\x00\x10" + header[22:]
    for start in (other, fragment, bytes(34)):
        assert without_checksum(start + udp + b"hi") == start + udp + b"hi"
