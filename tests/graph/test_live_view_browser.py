"""The live view's page in a real browser without a window: what it shows, and a goal by mouse.

Needs Chromium (chromium.py). Where there is none the test is skipped, and says so in a warning too;
with FLOORNAV_NEEDS_BROWSER=1, which `.ci/run` sets, it fails.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from chromium import Chromium, find_chromium

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped  # noqa: E402
from live_scene import CELL_M, CORNER, GLASS_COL, Scene  # noqa: E402, I001
from test_live_view import begin  # noqa: E402

SIZE = (1200, 800)
TOL_COLOR = 12
FREE, WALL, GLASS = (247, 249, 251), (28, 36, 48), (0, 180, 216)
MISSING = (
    "no Chromium found: the live view's page is NOT tested in a browser. Install it (Debian: "
    "apt install chromium) or name it in FLOORNAV_CHROMIUM"
)


@pytest.fixture
def browser(tmp_path: Path):
    """Return a browser; see the module for what happens without one."""
    program = find_chromium()
    if program is None:
        if os.environ.get("FLOORNAV_NEEDS_BROWSER") == "1":
            pytest.fail(MISSING)
        warnings.warn(MISSING, stacklevel=1)
        pytest.skip(MISSING)
    made = Chromium(program, tmp_path, SIZE)
    yield made
    made.close()


def wait_for(browser: Chromium, scene: Scene, script: str) -> Any:
    """Return the first value of JavaScript that counts as true, while the robot's nodes go on."""
    found: list[Any] = []

    def look() -> bool:
        scene.say_all()
        found.append(browser.value(f"(() => {{ try {{ return {script}; }} catch {{ }} }})()"))
        return bool(found[-1])

    scene.peer.spin_until(look)
    return found[-1]


def on_screen(browser: Chromium, x: float, y: float) -> tuple[float, float]:
    """Return where on the page a place of the map is, px."""
    place: list[float] = browser.value(f"toScreen({x}, {y})")
    return place[0], place[1]


def color_at(browser: Chromium, picture: np.ndarray, x: float, y: float) -> tuple[int, ...]:
    """Return the color, red first, of a place of the map in a picture of the page."""
    column, row = (round(v) for v in on_screen(browser, x, y))
    return tuple(int(v) for v in picture[row, column, ::-1])


def is_near(color: tuple[int, ...], wanted: tuple[int, ...]) -> bool:
    return max(abs(a - b) for a, b in zip(color, wanted, strict=True)) <= TOL_COLOR


def test_the_page_shows_the_robot_takes_a_goal_and_says_when_the_node_is_gone(
    start: Callable[..., Any], peer: Any, browser: Chromium, tmp_path: Path
) -> None:
    node, url = begin(start)
    scene = Scene(peer, node)
    scene.begin_all(node)
    browser.open(url)
    drawn = ("map", "glass", "scan", "pose", "path", "sonar", "markers", "planner", "image")
    wait_for(browser, scene, f"{list(drawn)}.every((slot) => slot in seen)")
    wait_for(browser, scene, '$("banner").hidden')  # nothing is missing any more
    wait_for(browser, scene, '$("troubles").textContent.includes("/driver: motor")')
    check_words(browser)
    check_picture(browser, tmp_path)
    check_goal(browser, scene, node, peer)
    check_loss_and_return(browser, scene, node, start, url)
    assert [e for e in browser.errors if "WebSocket connection" not in e] == []


def check_words(browser: Chromium) -> None:
    """The side says what the nodes do."""
    for part, words in (("state", "waiting"), ("reason", "a person is on the way")):
        assert browser.value(f'$("planner").querySelector(".{part}").textContent') == words
    assert browser.value('$("planner").dataset.level') == "1"
    assert "ERROR: hot" in browser.value('$("troubles").textContent')
    browser.wait_for('$("camera").querySelector("img").naturalWidth === 60')


def check_picture(browser: Chromium, folder: Path) -> None:
    """The room is in the middle; free floor, walls and glass have their colors where they are."""
    browser.wait_for("(isDirty === false)")
    data = browser.screenshot()
    (folder / "live_view.png").write_bytes(data)
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    middle = 0.5 * CELL_M
    pane = CORNER + GLASS_COL * CELL_M + middle, 0.25
    assert on_screen(browser, 2.0, 1.0) == pytest.approx(browser.value("middle()"), abs=1.0)
    assert is_near(color_at(browser, picture, *pane), GLASS)
    assert is_near(color_at(browser, picture, -0.45, -0.45), FREE)
    assert is_near(color_at(browser, picture, CORNER + middle, 1.53), WALL)
    red, _, blue = color_at(browser, picture, 1.0, 0.1)  # on the robot
    assert blue > red + 50


def check_goal(browser: Chromium, scene: Scene, node: Any, peer: Any) -> None:
    """The button, then press at the place and drag up: a goal that looks along +y."""
    goals = peer.collect(PoseStamped, "/goal_pose", 10)
    node.wait_for("/goal_pose is sent to 2")
    x, y = on_screen(browser, 2.0, -0.4)
    browser.drag(x, y, x, y - 60)  # no goal: without the button this moves the map
    browser.value("fit()")
    left, top, wide, high = browser.value(
        '(({ x, y, width, height }) => [x, y, width, height])($("goal").getBoundingClientRect())'
    )
    browser.drag(*2 * (left + wide / 2, top + high / 2))
    assert browser.value("isAiming") is True
    browser.drag(x, y, x, y - 60)
    peer.spin_until(lambda: bool(goals))
    (goal,) = goals
    pixel_m = 1.0 / browser.value("view.scale")
    assert goal.pose.position.x == pytest.approx(2.0, abs=2 * pixel_m)
    assert goal.pose.position.y == pytest.approx(-0.4, abs=2 * pixel_m)
    yaw = 2.0 * math.atan2(goal.pose.orientation.z, goal.pose.orientation.w)
    assert yaw == pytest.approx(math.pi / 2, abs=0.05)
    assert browser.value("isAiming") is False  # the next click does not drive the robot
    wait_for(browser, scene, '$("answer").textContent.includes("sent on /goal_pose")')


def check_loss_and_return(
    browser: Chromium, scene: Scene, node: Any, start: Callable[..., Any], url: str
) -> None:
    """Without the node the page says so; when it is back, the page is too."""
    node.stop()
    browser.wait_for('!$("banner").hidden && $("banner").textContent.includes("No connection")')
    begin(start, port=int(url.rstrip("/").rpartition(":")[2]))
    wait_for(browser, scene, '$("banner").hidden')
