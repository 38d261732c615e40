"""What goes wrong with one robot of a team: it is carried away, lies, falls silent, is turned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from experiments.team_views_sim import Scene
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_views import NOBODY, RobotView

FAULTY = 0
_CARRIED_M, _TURNED = 3.0, float(np.radians(60.0))


def carried_away(scene: Scene) -> Scene:
    """Return the scene with one rough pose 3 m and 60 degrees off, as sure of itself as ever."""
    view = scene.views[FAULTY]
    assert view.rough is not None
    toward = -np.sign(view.rough.pose.x) or 1.0  # so that it stays about on the field
    off = SE2(
        view.rough.pose.x + _CARRIED_M * toward, view.rough.pose.y, view.rough.pose.yaw + _TURNED
    )
    return _with(scene, replace(view, rough=PoseEstimate(off, view.rough.cov)))


def lying(scene: Scene) -> Scene:
    """Return the scene with one robot whose bearings, all of them, are made up."""
    view = scene.views[FAULTY]
    rng = np.random.default_rng(len(view.bearings))
    posts = {kind: rng.uniform(-np.pi, np.pi, len(b)) for kind, b in view.landmark_bearings.items()}
    made_up = rng.uniform(-np.pi, np.pi, len(view.bearings))
    told = replace(view, bearings=made_up, landmark_bearings=posts)
    ids = (np.full(len(made_up), NOBODY), *scene.true_ids[1:])
    return replace(_with(scene, told), true_ids=ids)


def silent(scene: Scene) -> Scene:
    """Return the scene with one robot that others see and that says nothing."""
    ids = (np.array([], dtype=int), *scene.true_ids[1:])
    return replace(_with(scene, RobotView(scene.views[FAULTY].name, np.array([]))), true_ids=ids)


def turned_camera(scene: Scene) -> Scene:
    """Return the scene with one robot that sees teammates 60 degrees beside where they are."""
    view = scene.views[FAULTY]
    return _with(scene, replace(view, bearings=view.bearings + _TURNED))


FAULTS: dict[str, Callable[[Scene], Scene]] = {
    "carried away": carried_away,
    "lying": lying,
    "silent": silent,
    "turned camera": turned_camera,
}


def _with(scene: Scene, view: RobotView) -> Scene:
    assert FAULTY == 0
    return replace(scene, views=(view, *scene.views[1:]), faulty=(FAULTY,))
