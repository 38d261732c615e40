"""Nodes as real processes over DDS: each test has a domain of its own and ends what it started."""

from __future__ import annotations

import importlib.util
import os
import socket
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from node_process import EVENTUALLY_S, NodeProcess

# Without ROS no node can be started: there is nothing to collect here.
collect_ignore_glob = [] if importlib.util.find_spec("rclpy") else ["test_*.py"]

SETTLE_S = 0.3  # the other side of a match hears of it a moment later
DOMAINS = range(60, 100)


def domains_of_worker() -> range:
    """Return the domains of this pytest process, apart from those of others of the same run."""
    number = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    return DOMAINS[number :: int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))]


def free_domain(taken: set[int] = set()) -> int:  # noqa: B006, remembers across tests on purpose
    """Return a ROS domain whose first discovery port nobody holds."""
    for domain in domains_of_worker():
        if domain in taken:
            continue
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("127.0.0.1", 7400 + 250 * domain + 10))
            except OSError:
                continue
        taken.add(domain)
        return domain
    assert taken, f"no free ROS domain in {list(domains_of_worker())}"
    taken.clear()
    return free_domain(taken)


class Peer:
    """The test's own side of the graph: a plain rclpy node, spun while it waits."""

    def __init__(self, domain: int, name: str = "test_peer") -> None:
        """Join the domain."""
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node(name, context=self.context)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._subscriptions: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}

    def spin(self, seconds: float) -> None:
        """Work for a while."""
        self.spin_until(lambda: False, seconds, must=False)

    def spin_until(
        self, is_done: Callable[[], bool], timeout: float = EVENTUALLY_S, *, must: bool = True
    ) -> bool:
        """Work until something is so; fails after the timeout."""
        end = time.monotonic() + timeout
        while not is_done():
            if time.monotonic() > end:
                assert not must, f"not so within {timeout} s"
                return False
            self._executor.spin_once(timeout_sec=0.02)
        return True

    def publisher(
        self, msg_type: type, topic: str, qos: Any, to: NodeProcess | None = None, num: int = 1
    ) -> Any:
        """Create a publisher and wait until it is heard by anyone, or by a node that says so.

        Args:
            msg_type: Message class.
            topic: Name.
            qos: Profile.
            to: Node that says whom it hears (listening.py).
            num: How many publishers it then hears, its own counted.
        """
        publisher = self.node.create_publisher(msg_type, topic, qos)
        self.spin_until(lambda: publisher.get_subscription_count() >= 1)
        if to is None:
            self.spin(SETTLE_S)
        else:
            to.wait_to_hear(publisher.topic_name, num)
        return publisher

    def call(self, srv_type: type, service: str, request: Any, to: NodeProcess) -> Any:
        """Return the answer of a service of a node that says who calls it (listening.py)."""
        if service not in self._clients:
            client = self._clients[service] = self.node.create_client(srv_type, service)
            self.spin_until(client.service_is_ready)
            to.wait_for(f"{client.srv_name} is called by")
        answer = self._clients[service].call_async(request)
        self.spin_until(answer.done)
        return answer.result()

    def trigger(self, service: str, to: NodeProcess) -> Any:
        """Return the answer of a Trigger service; see `call`."""
        from std_srvs.srv import Trigger

        return self.call(Trigger, service, Trigger.Request(), to)

    def publish_until(
        self, publisher: Any, msg: Any, is_done: Callable[[], bool], timeout: float = EVENTUALLY_S
    ) -> None:
        """Publish again and again: the first of a best-effort topic may find nobody yet."""
        end = time.monotonic() + timeout
        while not is_done():
            assert time.monotonic() < end, f"not so within {timeout} s"
            publisher.publish(msg)
            self.spin_until(is_done, 0.1, must=False)

    def collect(self, msg_type: type, topic: str, qos: Any) -> list[Any]:
        """Return a list that fills with the messages of a topic."""
        messages: list[Any] = []
        subscription = self.node.create_subscription(msg_type, topic, messages.append, qos)
        self._subscriptions[topic] = subscription
        return messages

    def wait_for_publisher(self, *topics: str) -> None:
        """Wait until topics (full names) are published.

        A subscription made after that hears its publisher from the moment the publisher knows of
        it; one made before may be known to the publisher first, and miss what is sent meanwhile.
        """
        for topic in topics:
            self.spin_until(lambda t=topic: self.node.count_publishers(t) > 0)

    def wait_to_hear(self, *topics: str) -> None:
        """Wait until what `collect` was given as topics has found a publisher."""
        for topic in topics:
            self.spin_until(lambda s=self._subscriptions[topic]: s.get_publisher_count() >= 1)

    def close(self) -> None:
        """Leave."""
        self._executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> int:
    """Return a ROS domain of this test's own, set in the environment; discovery on this host."""
    number = free_domain()
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    return number


@pytest.fixture
def start(domain: int) -> Iterator[Callable[..., NodeProcess]]:
    """Return a function that starts `python SCRIPT_OR_-m_WORDS ...` as a process."""
    started: list[NodeProcess] = []

    def _start(*words: str | Path) -> NodeProcess:
        started.append(NodeProcess([sys.executable, *map(str, words)], dict(os.environ)))
        return started[-1]

    yield _start
    for process in started:
        process.kill()


@pytest.fixture
def make_peer(domain: int) -> Iterator[Callable[..., Peer]]:
    """Return a function that joins the graph under a node name."""
    peers: list[Peer] = []

    def _make(name: str = "test_peer") -> Peer:
        peers.append(Peer(domain, name))
        return peers[-1]

    yield _make
    for peer in peers:
        peer.close()


@pytest.fixture
def peer(make_peer: Callable[..., Peer]) -> Peer:
    """Return a node of the test's own in the graph."""
    return make_peer()
