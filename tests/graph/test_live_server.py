"""The live view's server alone: who is let in, and a browser that does not read."""

from __future__ import annotations

import http.client
import time
from collections.abc import Iterator

import pytest
from browsers import Looker
from websockets.exceptions import InvalidStatus

from floornav_common.live_view.encoding import binary_message, text_message
from floornav_common.live_view.server import MAX_BROWSERS, LiveViewServer

MIB = 1 << 20


@pytest.fixture
def server() -> Iterator[LiveViewServer]:
    made = LiveViewServer(0)
    yield made
    made.close()


def port_of(server: LiveViewServer) -> int:
    return int(server.url.rstrip("/").rpartition(":")[2])


def fetch(server: LiveViewServer, path: str, host: str = "") -> tuple[int, str, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", port_of(server), timeout=30)
    connection.request("GET", path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    text, headers = answer.read().decode(), dict(answer.getheaders())
    connection.close()
    return answer.status, text, headers


def wait_for(is_so) -> None:
    end = time.monotonic() + 60.0
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_it_listens_on_loopback_only(server: LiveViewServer) -> None:
    assert server.url.startswith("http://127.0.0.1:")
    assert server._listener.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize(
    ("path", "kind"),
    [("/", "text/html"), ("/live_view.js", "text/javascript"), ("/live_view.css", "text/css")],
)
def test_the_page_is_served_and_no_other_may_frame_it(
    server: LiveViewServer, path: str, kind: str
) -> None:
    status, text, headers = fetch(server, path)
    assert (status, headers["Content-Type"]) == (200, f"{kind}; charset=utf-8")
    assert len(text.encode()) == int(headers["Content-Length"]) > 1000
    assert headers["X-Frame-Options"] == "DENY"
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]


@pytest.mark.parametrize(
    "path", ["/x", "/../server.py", "/page/index.html", "//", "/live_view.js/"]
)
def test_nothing_else_is_served(server: LiveViewServer, path: str) -> None:
    assert fetch(server, path)[0] == 404


def test_a_name_that_only_leads_here_is_refused(server: LiveViewServer) -> None:
    status, text, _ = fetch(server, "/", host=f"evil.example:{port_of(server)}")
    assert status == 403
    assert "Host must be" in text


def test_a_page_from_elsewhere_gets_no_websocket(server: LiveViewServer) -> None:
    for origin in ("http://evil.example", f"http://localhost:{port_of(server)}", "null"):
        with pytest.raises(InvalidStatus) as refused:
            Looker(server.url, origin=origin)
        assert refused.value.response.status_code == 403
    assert server.num_browsers == 0
    assert server.counts["requests refused"] == 3


def test_its_own_page_gets_a_websocket_and_what_is_sent(server: LiveViewServer) -> None:
    looker = Looker(server.url, origin=server.url.rstrip("/"))
    wait_for(lambda: server.num_browsers == 1)
    server.send({"pose": text_message("pose", x=1.0)})
    looker.until(lambda: looker.values("pose"))
    assert looker.values("pose")["x"] == 1.0
    looker.close()
    wait_for(lambda: server.num_browsers == 0)


def test_no_more_than_so_many_browsers_are_let_in(server: LiveViewServer) -> None:
    lookers = [Looker(server.url) for _ in range(MAX_BROWSERS)]
    wait_for(lambda: server.num_browsers == MAX_BROWSERS)
    with pytest.raises(InvalidStatus) as refused:
        Looker(server.url)
    assert refused.value.response.status_code == 503
    for looker in lookers:
        looker.close()


def test_one_that_sends_too_much_is_thrown_out_and_the_others_stay(server: LiveViewServer) -> None:
    rude, other = Looker(server.url), Looker(server.url)
    wait_for(lambda: server.num_browsers == 2)
    rude.say("x" * MIB)
    wait_for(lambda: server.num_browsers == 1)
    server.send({"pose": text_message("pose", x=2.0)})
    other.until(lambda: other.values("pose"))
    other.close()
    rude.close()


def test_goals_wait_for_the_node_and_only_so_many(server: LiveViewServer) -> None:
    looker = Looker(server.url)
    for k in range(40):
        looker.say(f'{{"kind": "goal", "x": {k}, "y": 0, "yaw": 0}}')
    looker.say("done")
    looker.until(lambda: looker.values("answer"))  # of what came last, and is no goal
    goals = server.take_goals()
    assert [goal.pose.x for goal in goals] == list(range(24, 40))
    assert server.take_goals() == []
    looker.close()


def test_a_browser_that_does_not_read_gets_the_newest_later_and_holds_up_nobody(
    server: LiveViewServer,
) -> None:
    """Without dropping, 300 MB would wait for it here."""
    slow, quick = Looker(server.url), Looker(server.url)
    wait_for(lambda: server.num_browsers == 2)
    payload = bytes(MIB)
    for k in range(300):
        server.send({"map": binary_message("map", payload, number=k)})
        quick.until(lambda k=k: quick.values("map").get("number") == k)
    assert server.counts["replaced by newer"] > 200
    slow.until(lambda: slow.values("map").get("number") == 299)
    assert slow.counts["map"] < 100
    assert quick.counts["map"] == 300
    for looker in (slow, quick):
        looker.close()


def test_the_port_is_free_again_after_the_end(server: LiveViewServer) -> None:
    looker = Looker(server.url)
    server.close()
    looker.until(lambda: looker.socket.protocol.state.name != "OPEN")
    looker.close()
    again = LiveViewServer(port_of(server))
    again.close()
