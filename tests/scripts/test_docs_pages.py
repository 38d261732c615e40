"""The pages under docs/: links lead somewhere, and the files that they give away can be used."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
TURTLEBOT = DOCS / "files" / "turtlebot4"
PAGES = sorted([ROOT / "README.md", *DOCS.glob("*.md"), *ROOT.glob("ros_ws/src/*/README.md")])
NODES = ("grid_mapper grid_mapper", "sjmc_planner local_planner")
TREE_NODES = {  # of Nav2's Jazzy behavior trees, with the ports that are used here
    "RecoveryNode": {"number_of_retries"},
    "PipelineSequence": set(),
    "RateController": {"hz"},
    "ComputePathToPose": {"goal", "path", "planner_id", "error_code_id"},
    "FollowPath": {"path", "controller_id", "error_code_id"},
    "ClearEntireCostmap": {"service_name"},
}


def anchors(page: Path) -> set[str]:
    """Return the anchors that a page's headings get where it is shown (GitHub's rule)."""
    found: dict[str, int] = {}
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for heading in re.findall(r"^#+ (.+)$", text, flags=re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        name = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")
        found[name] = found.get(name, -1) + 1
        if found[name]:
            found[f"{name}-{found[name]}"] = 0
    return set(found)


def test_anchors_are_those_that_a_heading_gets(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# A `b`: c, d\n\n```\n# no heading\n```\n## Nav2's x_y\n### Twice\n### Twice\n"
    )
    assert anchors(page) == {"a-b-c-d", "nav2s-x_y", "twice", "twice-1"}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_every_anchor_that_a_page_links_to_is_a_heading(page: Path) -> None:
    missing = []
    for target in re.findall(r"\]\(([^)\s]*#[^)\s]+)\)", page.read_text(encoding="utf-8")):
        name, _, anchor = target.partition("#")
        other = (page.parent / name).resolve() if name else page
        if not name.startswith("http") and other.suffix == ".md" and other.exists():
            missing += [target] if anchor not in anchors(other) else []
    assert not missing


def test_every_page_is_in_the_table_of_contents() -> None:
    contents = (DOCS / "README.md").read_text(encoding="utf-8")
    assert [
        p.name for p in DOCS.glob("*.md") if p.name not in ("README.md", *links(contents))
    ] == []


def links(text: str) -> list[str]:
    """Return the pages of docs/ that a text links to."""
    return [target.partition("#")[0] for target in re.findall(r"\]\(([^)]+)\)", text)]


def nav2() -> dict[str, Any]:
    """Return the parameters of Nav2's nodes by node name."""
    content = yaml.safe_load((TURTLEBOT / "nav2.yaml").read_text(encoding="utf-8"))
    return {name.rpartition("/")[2]: block["ros__parameters"] for name, block in content.items()}


@pytest.mark.parametrize("node", NODES)
def test_our_nodes_accept_the_turtlebots_parameters(node: str) -> None:
    from _docs_parameters import NODES as CLASSES
    from floornav_common.config_files import flat_values, load_config, read_parameters

    path, name = TURTLEBOT / "floornav.yaml", node.split()[1]
    classes = CLASSES[node]
    given = read_parameters(path, name)
    assert len(given) > 3
    values: dict[str, Any] = {}
    for config_class in classes:
        values |= flat_values(load_config(path, config_class, node=name, others=classes))
    as_given = {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}
    assert {key: as_given[key] for key in given} == given


def test_every_plugin_of_nav2_that_is_listed_is_described() -> None:
    lists = [
        (parameters, name)
        for parameters in nav2().values()
        for key in ("plugins", "planner_plugins", "navigators", "polygons", "observation_sources")
        for name in parameters.get(key, [])
    ]
    assert len(lists) == 8
    for parameters, name in lists:
        assert {"plugin", "type"} & set(parameters[name]), name


def test_both_static_layers_are_fed_by_grid_mapper_and_neither_overwrites_the_other() -> None:
    costmap = nav2()["global_costmap"]
    static = [n for n in costmap["plugins"] if "StaticLayer" in costmap[n]["plugin"]]
    assert [costmap[n]["map_topic"] for n in static] == ["/robot1/map", "/robot1/map/glass"]
    assert costmap["use_maximum"] is True
    assert all(costmap[n]["map_subscribe_transient_local"] for n in static)


def test_commands_go_from_local_planner_through_the_collision_monitor() -> None:
    from floornav_common.config_files import read_parameters

    ours = read_parameters(TURTLEBOT / "floornav.yaml", "local_planner")
    monitor = nav2()["collision_monitor"]
    page = (DOCS / "nav2.md").read_text(encoding="utf-8")
    assert monitor["enable_stamped_cmd_vel"] == ours["enable_stamped_cmd_vel"]
    assert f"-r cmd_vel:={monitor['cmd_vel_in_topic']}" in page
    assert monitor["approach"]["radius"] >= ours["robot.radius_m"]
    assert "local_planner" not in nav2()["lifecycle_manager"]["node_names"]


def test_the_behavior_tree_asks_only_for_what_is_started() -> None:
    tree = ET.parse(TURTLEBOT / "navigate_by_local_planner.xml").getroot()
    assert tree.attrib["BTCPP_format"] == "4"
    (body,) = tree
    assert body.attrib["ID"] == tree.attrib["main_tree_to_execute"]
    steps = [step for step in body.iter() if step is not body]
    for step in steps:
        assert set(step.attrib) - {"name"} <= TREE_NODES[step.tag], step.tag
        assert step.tag != "RecoveryNode" or len(step) == 2
    codes = {s.attrib["error_code_id"].strip("{}") for s in steps if "error_code_id" in s.attrib}
    assert codes == set(nav2()["bt_navigator"]["error_code_names"])
    named = nav2()["bt_navigator"]["default_nav_to_pose_bt_xml"]
    assert Path(named).name == "navigate_by_local_planner.xml"
    assert "local_costmap" not in ET.tostring(tree, encoding="unicode")


def test_the_world_of_the_floor_plan_has_its_walls_on_the_plans_corners() -> None:
    pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be read")
    from multi_localizer.floor_plan import load_plan
    from sim_bridge.world import load_world

    folder = DOCS / "files" / "own_floor"
    plan = load_plan(str(folder / "my_room.yaml"))
    walls = load_world(folder / "my_room_world.yaml").walls
    middle = [tuple(wall.from_m) for wall in walls]
    assert len(middle) == len(plan.corners)
    half = walls[0].thickness_m / 2
    for at, corner in zip(middle, plan.corners, strict=True):
        assert [abs(a - c) for a, c in zip(at, corner, strict=True)] == pytest.approx([half] * 2)
    page = (DOCS / "own-floor-plan.md").read_text(encoding="utf-8")
    assert (folder / "my_room.yaml").read_text(encoding="utf-8") in page


def test_the_sonar_driver_fills_what_its_page_asks_for() -> None:
    source = (DOCS / "files" / "sonar_driver.py").read_text(encoding="utf-8")
    compile(source, "sonar_driver.py", "exec")
    asked = re.findall(
        r"^\| `([a-z_.]+)`.* \|$",
        (DOCS / "add-a-sonar.md").read_text(encoding="utf-8").partition("## Check it")[0],
        flags=re.M,
    )
    assert asked[0] == "header.stamp"
    assert [field for field in asked if field not in source] == []
