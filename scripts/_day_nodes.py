"""The processes of a demo with goals: which nodes, told what, for the sensors of a robot."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import yaml

from _day_robot import OURS, pilot_of
from floornav_common.camera_files import save_camera
from sim_bridge.robot_model import RobotModel
from sim_bridge.world import World

SCRIPTS = Path(__file__).resolve().parent
MAP_NODES = ("grid_mapper", "wavefront_planner", "local_planner")
OMNI_NODES = ("floor_detector", "marker_detector")
STEREO_NODES = ("stereo_matcher", "stereo_localizer")
BUILDING = "building"
"""Frame of the voxel map: the world's own; `map` is where the robot started."""
_MODULES = {
    "grid_mapper": "grid_mapper.nodes.grid_mapper_node",
    "wavefront_planner": "sjmc_planner.nodes.wavefront_planner_node",
    "local_planner": "sjmc_planner.nodes.local_planner_node",
    "floor_detector": "floor_perception.nodes.floor_detector_node",
    "marker_detector": "floor_perception.nodes.marker_detector_node",
    "stereo_matcher": "multi_localizer.nodes.stereo_matcher_node",
    "stereo_localizer": "multi_localizer.nodes.stereo_localizer_node",
    "sim_bridge": "sim_bridge.nodes.sim_bridge_node",
}
_RECORDED = (
    "/scan", "/sonar", "/odom", "/tf", "/tf_static", "/pose", "/map", "/map/glass", "/cmd_vel",
    "/robot_description", "/path", "/goal_pose", "/planner/state", "/planner/markers",
    "/floor/free_space", "/stereo_pose", "/ground_truth/odom", "/ground_truth/contact",
    "/ground_truth/people",
)  # fmt: skip
_RANGE_MIN_M, _HORIZON_M, _MARK_M = 0.95, 4.0, 0.03
_PANORAMA_M = 0.12  # a whole flat: half as many places as for one room
_PACE_LAG_S = 0.2


def node_names(model: RobotModel) -> list[str]:
    """Return the nodes that a robot's sensors ask for, sim_bridge left out."""
    omni = OMNI_NODES if model.config.omni is not None else ()
    stereo = STEREO_NODES if model.config.stereo is not None else ()
    return [*MAP_NODES, *omni, *stereo]


def write_settings(folder: Path, world: World, model: RobotModel) -> Path:
    """Write what every node is told and the camera's file; return the file of parameters."""
    folder.mkdir(parents=True, exist_ok=True)
    pilot = pilot_of(world, model, OURS)
    told: dict[str, dict[str, Any]] = {
        "grid_mapper": changed(pilot.mapper),
        "wavefront_planner": changed(pilot.wavefront),
        "local_planner": changed(pilot.planner),
    }
    if model.config.omni is not None:
        camera = folder / "omni_camera.yaml"
        save_camera(model.config.omni.camera(), camera)
        seen = {"camera_model": str(camera), "image_timeout_s": 2.0}
        template = {"range_min_m": _RANGE_MIN_M, "horizon_m": _HORIZON_M}
        # The simulator starts last, and it says where the camera is.
        known = {"publish_tf": False, "mask": {"mark_m": _MARK_M}}
        told["floor_detector"] = {**seen, **known, "template": template}
        told["marker_detector"] = seen
    if model.config.stereo is not None:
        place = {
            "map_file": str(folder / "voxel_map.npz"),
            "map_frame": BUILDING,
            "panorama_spacing_m": _PANORAMA_M,
        }
        for name, more in zip(STEREO_NODES, ({}, place), strict=True):
            pairs = list(model.config.stereo.pairs)  # a list of its own: rcl reads no YAML aliases
            told[name] = {"pairs": pairs, "image_timeout_s": 3.0, **more}
    path = folder / "nodes.yaml"
    nodes = {f"/**/{node}": {"ros__parameters": values} for node, values in told.items()}
    path.write_text(yaml.safe_dump(nodes, sort_keys=False))
    return path


def changed(config: Any) -> dict[str, Any]:
    """Return what differs from a settings' defaults, groups as mappings."""
    usual = asdict(type(config)())
    found = {f.name: asdict(config)[f.name] for f in fields(config)}
    return _differing(found, usual)


def _differing(values: dict[str, Any], usual: dict[str, Any]) -> dict[str, Any]:
    differing = {}
    for key, value in values.items():
        if isinstance(value, dict):
            if inner := _differing(value, usual[key]):
                differing[key] = inner
        elif value != usual[key]:
            differing[key] = value
    return differing


def node_command(name: str, settings: Path) -> list[str]:
    """Return the command that starts one node."""
    words = ["--ros-args", "--params-file", str(settings), "-p", "use_sim_time:=true"]
    return [sys.executable, "-m", _MODULES[name], *words]


def record_command(bag: Path, *, with_images: bool, model: RobotModel) -> list[str]:
    """Return the command that records; images only if asked for."""
    topics = [*_RECORDED, *(_image_topics(model) if with_images else ())]
    return [sys.executable, str(SCRIPTS / "record.py"), *topics, "--out", str(bag)]


def simulator_command(
    args: argparse.Namespace, listeners: list[str], has_window: bool
) -> list[str]:
    """Return the command that starts the simulator, whose time waits for those who listen."""
    told = {
        "world": str(args.world),
        "seed": str(args.seed),
        "real_time_factor": str(float(args.rtf)),
        "view": str(has_window).lower(),
        "start_nodes": f"[{', '.join(listeners)}, bag_recorder, demo_watch]",
        "pace_nodes": "[grid_mapper, local_planner]",
        "pace_lag_s": str(_PACE_LAG_S),
    }
    if args.set:
        told["world_parameters"] = "[" + ", ".join(args.set) + "]"
    words = [word for key, value in told.items() for word in ("-p", f"{key}:={value}")]
    return [sys.executable, "-m", _MODULES["sim_bridge"], "--ros-args", *words]


def _image_topics(model: RobotModel) -> list[str]:
    topics = [] if model.config.omni is None else ["/omni/image_raw"]
    for pair in () if model.config.stereo is None else model.config.stereo.pairs:
        topics += [f"/stereo/{pair}/{side}/image_rect" for side in ("left", "right")]
        topics += [f"/stereo/{pair}/{side}/camera_info" for side in ("left", "right")]
    return topics
