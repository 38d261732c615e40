"""Pictures and page of a demo that drives through a world without mapping it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from _tour_watch import RobotHeard, TourWatch
from floornav_common.reporting import Figures, Picture, Section, Table, write_html
from floornav_common.transform3 import Transform3
from sim_bridge.drawing import draw_from_above, extent_of, plain
from sim_bridge.people.config import PeopleConfig
from sim_bridge.robot_model import RobotModel
from sim_bridge.simulation import Simulation
from sim_bridge.world import World

_LASER, _SONAR, _PERSON = "#d7301f", "#6a3fb5", "#e0861a"
_ROBOTS = ("#1a7f4b", "#2b7de0", "#8a5cc2", "#b5651d", "#0f8a8a", "#c2185b", "#5d7a00", "#455a64")


def write_plan(
    path: Path,
    world: World,
    models: Mapping[str, RobotModel],
    heard: TourWatch,
) -> None:
    """Draw everything from above: ways of robots and people, and the last scan and echoes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    empty = replace(world, robots=(), people=(), crowd=None)
    scenery = Simulation(plain(replace(empty, recorded_people=None)))
    low, high = extent_of(scenery, _places(heard))
    share = float((high - low)[1] / (high - low)[0])
    width = min(11.0, 9.0 / share)
    figure, axes = plt.subplots(figsize=(width, width * share + 1.0), layout="constrained")
    draw_from_above(axes, scenery, (low, high))
    scenery.close()
    _draw_people(axes, heard, world.people_model)
    for number, (name, model) in enumerate(models.items()):
        color = _ROBOTS[number % len(_ROBOTS)]
        _draw_robot(axes, name, model, heard.robots[name], color)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    figure.legend(loc="outside upper center", ncols=8, frameon=False)
    figure.savefig(path, dpi=100)
    plt.close(figure)


def write_images(out: Path, robots: Mapping[str, RobotHeard]) -> list[Picture]:
    """Write the last image of every camera; returns them for the page."""
    from matplotlib.image import imsave

    pictures = []
    for name, heard in robots.items():
        for topic, image in heard.images.items():
            whole = f"{name}/{topic}" if name else topic
            path = out / f"{whole.replace('/', '_')}.png"
            imsave(path, image)
            size = f"{image.shape[1]} x {image.shape[0]}"
            pictures.append(Picture(path, f"{whole}, {size}, the last of {heard.counts[topic]}"))
    return pictures


def changed_people_model(world: World) -> dict[str, list[Any]] | None:
    """Return what a world changes of how people are: value and default by key; None if nothing."""
    usual = vars(PeopleConfig())
    changed = {k: [v, usual[k]] for k, v in vars(world.people_model).items() if v != usual[k]}
    return changed or None


def people_section(changed: Mapping[str, list[Any]] | None) -> list[Section]:
    """Return the section that says what a world changes of how people are; none if nothing."""
    if changed is None:
        return []
    rows = [[key, *map(str, values)] for key, values in changed.items()]
    text = "This world's people are not those of sim_bridge/people/config.py:"
    return [Section("People", [text, Table(["people_model", "here", "default"], rows)])]


def write_page(
    out: Path,
    title: str,
    values: dict[str, Any],
    problem: str,
    images: list[Picture],
    *,
    has_glass: bool,
) -> None:
    """Write `report.html`; `has_glass` tells of the world."""
    bad = problem.splitlines()[0] if problem else touched_text(values["robots"])
    state = ("result", bad, "bad") if bad else ("result", "done, nothing touched", "good")
    shown = Figures(
        [
            state,
            ("simulated", f"{values['sim_s']:.1f} s"),
            ("robots", str(len(values["robots"]))),
            ("people, at most", str(values["people"])),
            ("times real time", f"{values['rtf']:.1f}" if values["rtf"] else "–"),
        ]
    )
    plan = (
        "From above: lines are the ways of robots and people (from ground truth), red the last "
        f"scan, violet arcs the last echoes{'; blue-green walls are glass' if has_glass else ''}. "
        "No planner steers: a simple script turns robots off what their scan shows, or drives a "
        "route or a circle, so they may touch things and people."
    )
    rows = [
        [
            name or "(unnamed)",
            row["model"],
            f"{row['path_m']:.2f}",
            "yes" if row["touched"] else "no",
            ", ".join(f"{num} {topic}" for topic, num in row["messages"].items()) or "none",
        ]
        for name, row in values["robots"].items()
    ]
    header = ["robot", "model", "driven [m]", "touched", "messages"]
    sections = [
        Section("", [shown, Picture(out / "plan.png", plan)]),
        Section(
            "World",
            [Picture(out / "world.png", "The world from above, after 6 s of such a drive.")],
        ),
        *([Section("Cameras", images)] if images else []),
        Section("Robots", [Table(header, rows)]),
        *people_section(values["people_model"]),
    ]
    write_html(out, title, sections, "Simulated by sim_bridge, over DDS, in simulated time")


def touched_text(robots: Mapping[str, Mapping[str, Any]]) -> str:
    """Return which share of the robots touched something, "" if none did."""
    num = sum(bool(row["touched"]) for row in robots.values())
    if len(robots) == 1 and num:
        return "the robot touched something"
    return f"{num} of {len(robots)} robots touched something" if num else ""


def tour_lines(values: Mapping[str, Any]) -> list[str]:
    """Return what the command says of a world that was pictured at the end."""
    num, people = len(values["robots"]), ""
    if values["people"]:
        people = f", {values['people']} {'person' if values['people'] == 1 else 'people'}"
    text = f"{values['sim_s']:.1f} s simulated: {num} robot{'s' if num > 1 else ''}{people}"
    touched = touched_text(values["robots"])
    return [f"{text}; {touched}" if touched else text]


def _draw_people(axes: Any, heard: TourWatch, body: PeopleConfig) -> None:
    if not heard.people:
        return
    points = np.array([(p.x, p.y) for _, people in heard.people for p in people]).reshape(-1, 2)
    axes.plot(*points.T, ".", color=_PERSON, ms=1.5, alpha=0.5, zorder=3)
    for k, person in enumerate(heard.people[-1][1]):
        outline = person @ (
            body.torso_radius_m
            * np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, 6.3, 25)])
        )
        axes.fill(*outline.T, color=_PERSON, zorder=6, label="people" if k == 0 else None)


def _draw_robot(axes: Any, name: str, model: RobotModel, heard: RobotHeard, color: str) -> None:
    if not heard.truth:
        return
    way = np.array([(pose.x, pose.y) for _, pose in heard.truth])
    # A white edge, so that the way shows on every floor.
    axes.plot(*way.T, color="white", lw=4.0, zorder=4)
    axes.plot(*way.T, color=color, lw=2.0, zorder=4, label=name or "robot")
    corners = heard.truth[-1][1] @ np.array(model.config.footprint_m)
    axes.fill(*corners.T, facecolor="white", edgecolor=color, lw=1.6, zorder=6)
    if heard.scan is not None and model.config.laser is not None:
        stamp_ns, scan = heard.scan
        points = _place(model, model.config.laser.frame, heard, stamp_ns) @ scan.points()
        axes.plot(*points.T, ".", color=_LASER, ms=2.2, zorder=5)
    for frame, (stamp_ns, reading) in heard.sonar.items():
        if reading.is_hit:
            angles = np.linspace(-0.5, 0.5, 13) * reading.field_of_view
            arc = reading.range * np.column_stack((np.cos(angles), np.sin(angles)))
            axes.plot(*(_place(model, frame, heard, stamp_ns) @ arc).T, color=_SONAR, lw=1.4)


def _place(model: RobotModel, frame: str, heard: RobotHeard, stamp_ns: int) -> Any:
    pose = heard.pose_at(stamp_ns)
    assert pose is not None
    return pose @ Transform3(model.mounts[frame]).to_se2()


def _places(heard: TourWatch) -> np.ndarray:
    """Return where robots and people were, (N, 2), m."""
    ways = [pose for robot in heard.robots.values() for _, pose in robot.truth]
    ways += [person for _, people in heard.people for person in people]
    return np.array([(pose.x, pose.y) for pose in ways]).reshape(-1, 2)
