"""Every node by itself: it says what it waits for, and describes every parameter."""

from __future__ import annotations

import configparser
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from node_process import EVENTUALLY_S, NodeProcess
from rcl_interfaces.msg import ParameterDescriptor, ParameterType
from rcl_interfaces.srv import DescribeParameters, ListParameters

import floornav_common
from multi_localizer.voxel_map import VoxelMap, save_voxel_map

LISTENING = Path(__file__).with_name("listening.py")
PACKAGES = Path(floornav_common.__file__).parents[2]
RUNS_ALONE = ("sim_bridge", "live_view")  # they wait for nobody
WAITS = re.compile(r"never arrived; published by nobody|waiting for|no bearings on /")
NUMBERS = (ParameterType.PARAMETER_INTEGER, ParameterType.PARAMETER_DOUBLE)
OF_ROS = ("use_sim_time", "start_type_description_service")


def node_modules() -> list[str]:
    """Return the modules of all nodes that `ros2 run` starts."""
    config = configparser.ConfigParser()
    scripts = ""
    for path in PACKAGES.glob("*/setup.cfg"):
        config.read(path)
        scripts += config["options.entry_points"]["console_scripts"] + "\n"
    nodes = re.findall(r"= (\w+)\.nodes\.start:(\w+)$", scripts, re.MULTILINE)
    return [f"{pkg}.nodes.{name}_node" for pkg, name in sorted(nodes) if name != "send_goal"]


def name_of(module: str) -> str:
    return module.rpartition(".")[2].removesuffix("_node")


@pytest.fixture
def run_alone(start: Callable[..., NodeProcess], tmp_path: Path) -> Callable[[str], NodeProcess]:
    """Return a function that starts a node with the least that it must be told."""

    def run(module: str) -> NodeProcess:
        words = []
        if name_of(module) == "team_localizer":
            words = ["-r", "__ns:=/r1", "-p", "team:=[r1, r2]"]
        if name_of(module) == "stereo_localizer":
            cells = np.zeros((2, 3, 3), bool)
            save_voxel_map(
                tmp_path / "map.npz", VoxelMap(np.zeros((2, 3, 3, 3), np.uint8), cells, 1.0, 1.0)
            )
            words = ["-p", f"map_file:={tmp_path / 'map.npz'}"]
        return start(LISTENING, module, "--ros-args", *words)

    return run


def wait_for_match(node: NodeProcess, pattern: re.Pattern[str]) -> None:
    end = time.monotonic() + EVENTUALLY_S
    while not any(pattern.search(line) for line in list(node.lines)):
        assert time.monotonic() < end and not node.has_ended, f"no {pattern} in:\n{node.text}"
        time.sleep(0.02)


def parameters_of(peer: Any, node: NodeProcess, full_name: str) -> list[ParameterDescriptor]:
    request = ListParameters.Request()
    names = peer.call(ListParameters, f"{full_name}/list_parameters", request, node).result.names
    mine = [n for n in names if n not in OF_ROS and not n.startswith("qos_overrides.")]
    request = DescribeParameters.Request(names=mine)
    return peer.call(
        DescribeParameters, f"{full_name}/describe_parameters", request, node
    ).descriptors


@pytest.mark.parametrize("module", node_modules())
def test_alone_it_says_what_it_waits_for_and_describes_its_parameters(
    run_alone, peer, module: str
) -> None:
    node = run_alone(module)
    node.wait_for("ready")
    if name_of(module) not in RUNS_ALONE:
        wait_for_match(node, WAITS)
    namespace = "/r1" if name_of(module) == "team_localizer" else ""
    described = parameters_of(peer, node, f"{namespace}/{name_of(module)}")
    assert len(described) >= 3
    assert [d.name for d in described if len(d.description) < 8] == []
    unbound = [d.name for d in described if d.type in NUMBERS and not has_unit_or_range(d)]
    assert unbound == []
    assert node.process.poll() is None


def has_unit_or_range(d: ParameterDescriptor) -> bool:
    return bool(
        d.additional_constraints
        or d.floating_point_range
        or d.integer_range
        or re.search(r"[\[(].+[\])]", d.description)
    )
