"""scripts/make_docs.py: the parameter reference, the tables between marks, and small pictures."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes and their parameters cannot be loaded")
pytest.importorskip("grid_mapper.nodes.grid_mapper_node", reason="no grid_mapper node")

ROOT = Path(__file__).resolve().parents[2]
NODE_CLASSES = {
    "floornav_common live_view": "floornav_common.nodes.live_view_node:LiveViewNode",
    "grid_mapper grid_mapper": "grid_mapper.nodes.grid_mapper_node:GridMapperNode",
    "sim_bridge sim_bridge": "sim_bridge.nodes.sim_bridge_node:SimBridgeNode",
    "sjmc_planner local_planner": "sjmc_planner.nodes.local_planner_node:LocalPlannerNode",
    "sjmc_planner send_goal": "sjmc_planner.nodes.send_goal_node:SendGoalNode",
    "sim_bridge route_follower": "sim_bridge.nodes.route_follower_node:RouteFollowerNode",
}
ROS_OWN = ("use_sim_time", "start_type_description_service", "qos_overrides.")


def test_the_parameter_reference_is_up_to_date():
    command = [sys.executable, str(ROOT / "scripts" / "make_docs.py"), "--check"]
    answer = subprocess.run(command, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr


def test_every_example_of_a_world_file_can_be_read_and_names_its_key():
    import yaml

    from _docs_world_files import SECTIONS, examples
    from _docs_world_texts import EXAMPLES
    from sim_bridge.schema import build, filled_in
    from sim_bridge.world import World

    assert len(examples()) == len(EXAMPLES) > 15 and set(EXAMPLES) <= set(SECTIONS)
    for text in examples():
        data = {"name": "example", **yaml.safe_load(text)}
        assert isinstance(build(World, filled_in(data, {}, "example"), "example"), World)
    for title, text in EXAMPLES.items():
        assert title == "Top level" or all(f"{key}:" in text for key in title.split(", "))


def test_the_reference_knows_every_executable_that_is_a_node():
    from _docs_parameters import NODES
    from floornav_common.compose import nodes_installed

    assert {name.replace("/", " ") for name in nodes_installed()} == set(NODES)


@pytest.mark.parametrize("name", sorted(NODE_CLASSES))
def test_a_running_node_declares_what_the_reference_lists(name: str):
    from _docs_parameters import documented_names

    if name == "sim_bridge sim_bridge":
        pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
    import rclpy

    module, _, class_name = NODE_CLASSES[name].partition(":")
    rclpy.init(args=["--ros-args", "-p", "live_view:port:=0"])  # its usual one may be taken
    node = getattr(importlib.import_module(module), class_name)()
    try:
        declared = {n for n in node.get_parameters_by_prefix("") if not n.startswith(ROS_OWN)}
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    assert declared == documented_names(name)


def test_a_table_keeps_rows_of_recordings_that_are_not_there():
    from _docs_recordings import RUN_HEAD
    from _docs_tables import MARK, with_table

    begin, end = (MARK.format(what=what, name="runs") for what in ("begin", "end"))
    page = f"before\n{begin}\n{RUN_HEAD}| a | 1 |\n| b | 2 |\n{end}\nafter\n"
    answer = with_table(page, "runs", RUN_HEAD, {"b": "| b | 3 |", "c": "| c | 4 |"}, "ab")
    assert answer == page.replace("| b | 2 |", "| b | 3 |\n| c | 4 |")


def test_a_page_without_marks_is_refused():
    from _docs_tables import MARK, with_block, with_table

    with pytest.raises(ValueError, match="lacks the line"):
        with_table("no marks", "runs", "", {}, "")
    begin, end = (MARK.format(what=what, name="line") for what in ("begin", "end"))
    assert with_block(f"a\n{begin}\nold\n{end}\n", "line", "new") == f"a\n{begin}\nnew\n{end}\n"


def test_a_map_is_laid_on_the_plan_of_its_floor_and_walls_that_moved_show():
    import cv2

    from _docs_references import laid_on, plan_errors
    from floornav_common.grid import OccupancyMap
    from floornav_common.se2 import SE2

    room = np.zeros((200, 260), np.int8)
    for corners in (((20, 20), (240, 180)), ((20, 20), (90, 100)), ((150, 120), (200, 140))):
        cv2.rectangle(room, *corners, 100, 2)
    plan, T_plan_ours = OccupancyMap(room, 0.05, SE2(-1.0, -2.0, 0.0)), SE2(5.0, 3.0, 0.4)
    ours = OccupancyMap(room, 0.05, T_plan_ours.inverse() @ plan.origin)
    found = laid_on(ours, plan)
    assert T_plan_ours.between(found).distance < 0.02
    errors = plan_errors(ours, plan)
    assert errors.near_share > 0.99 and errors.median_m < 0.03 and errors.iou > 0.9
    moved = room.copy()
    moved[118:145, 145:205] = 0
    cv2.rectangle(moved, (170, 40), (215, 90), 100, 2)
    less = plan_errors(OccupancyMap(moved, 0.05, ours.origin), plan)
    share = 1.0 - (moved[38:95, 165:220] > 0).sum() / (moved > 0).sum()
    assert less.near_share == pytest.approx(share, abs=0.03) and less.iou < errors.iou - 0.05


def test_a_large_picture_is_cut_and_made_small():
    import cv2

    from _docs_pictures import MAX_BYTES, MAX_SIDE_PX, small_png

    image = np.full((1600, 3000, 3), 255, np.uint8)
    tiles = np.random.default_rng(0).integers(0, 240, (40, 100, 3))
    image[400:1200, 500:2500] = np.kron(tiles, np.ones((20, 20, 1)))
    data = small_png(image)
    back = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert len(data) <= MAX_BYTES
    assert max(back.shape) <= MAX_SIDE_PX
    assert back.shape[1] / back.shape[0] == pytest.approx(2000 / 800, rel=0.05)


def test_every_picture_and_page_that_the_docs_name_is_there():
    import re

    pages = [*(ROOT / "docs").glob("*.md"), *(ROOT / "ros_ws" / "src").glob("*/README.md")]
    missing = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in pages
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
        if not target.startswith("http") and not (page.parent / target).exists()
    ]
    assert not missing, "\n".join(missing)


def test_messages_that_troubleshooting_quotes_are_in_the_code():
    import re

    folders = (ROOT / "ros_ws" / "src", ROOT / "scripts")
    code = "".join(p.read_text(encoding="utf-8") for f in folders for p in f.rglob("*.py"))
    code = re.sub(r"\"\s*\n\s*f?\"", "", code).replace('\\"', '"')
    text = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
    quoted = re.findall(r"^\| `([^`]+)`", text, flags=re.MULTILINE)
    assert len(quoted) > 30
    missing = [
        part.strip()
        for message in quoted
        for part in re.split(r"\.\.\.|[;:,()']", message)
        if len(part.split()) > 1 and part.strip() not in code
    ]
    assert not missing, "\n".join(missing)
