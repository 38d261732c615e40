"""The nearest points of shapes in a cone of sound: no thing is too thin for a sonar."""

import numpy as np
import pytest

from sim_bridge.nearest import nearest_point
from sim_bridge.shape_kinds import BOX, CYLINDER, SPHERE
from sim_bridge.snapshot import snapshot
from sim_bridge.world import Column, Furniture, RobotPlacement, Wall, World

from .test_glass_worlds import EXACT_SONAR

SONAR_X, TOL_M = 0.2, 0.005
HALF_CONE_DEG = 10.0
BEARINGS_DEG = np.arange(-9.5, 9.6, 0.5)


def _front_range(world: World) -> float:
    pose = world.robots[0].pose
    return snapshot(world, pose).sonar[0].range


def _world(*, yaw_deg: float = 0.0, **things: tuple) -> World:
    robot = RobotPlacement(
        model="segway_rmp50", position_m=(0, 0), yaw_deg=yaw_deg,
        overrides={"laser": None, "sonar": EXACT_SONAR},
    )  # fmt: skip
    return World(name="thin", robots=(robot,), **things)


def _at(bearing_deg: float, distance: float) -> tuple[float, float]:
    angle = np.radians(bearing_deg)
    return SONAR_X + distance * np.cos(angle), distance * np.sin(angle)


def test_nearest_points_by_hand() -> None:
    face = nearest_point(BOX, 1.0, 2.0, 3.0, 4.0, 0.5, -1.0)
    edge = nearest_point(BOX, 1.0, 2.0, 3.0, 4.0, 5.0, -1.0)
    side = nearest_point(CYLINDER, 1.0, 1.0, 3.0, 3.0, 4.0, 2.0)
    rim = nearest_point(CYLINDER, 1.0, 1.0, 3.0, 3.0, 4.0, 8.0)
    ball = nearest_point(SPHERE, 1.0, 1.0, 1.0, 0.0, 3.0, 4.0)
    expected = [(1, 0.5, -1), (1, 2, -1), (0.6, 0.8, 2), (0.6, 0.8, 3), (0, 0.6, 0.8)]
    assert np.array([face, edge, side, rim, ball]) == pytest.approx(np.array(expected), abs=1e-5)


@pytest.mark.parametrize(("radius", "distance"), [(0.03, 1.0), (0.03, 3.0), (0.065, 3.0)])
def test_a_thin_post_is_heard_at_every_bearing_in_the_cone(radius: float, distance: float) -> None:
    heard = [
        _front_range(
            _world(columns=(Column(name="post", center_m=_at(b, distance), radius_m=radius),))
        )
        for b in BEARINGS_DEG
    ]
    assert heard == pytest.approx([distance - radius] * len(heard), abs=TOL_M)


def test_a_post_beside_the_cone_is_not_heard() -> None:
    post = Column(name="post", center_m=_at(14.0, 2.0), radius_m=0.03)
    assert np.isinf(_front_range(_world(columns=(post,))))


def test_a_post_behind_a_wall_is_not_heard() -> None:
    post = Column(name="post", center_m=_at(4.0, 3.0), radius_m=0.03)
    wall = Wall(from_m=(1.5, -1.0), to_m=(1.5, 1.0))
    heard = _front_range(_world(columns=(post,), walls=(wall,)))
    assert heard == pytest.approx(1.44 - SONAR_X, abs=TOL_M)


def test_a_thin_board_that_faces_the_sonar_is_heard_and_one_at_a_slant_is_not() -> None:
    def board(yaw_deg: float) -> World:
        size = (0.02, 0.02, 1.0)
        box = Furniture(name="b", center_m=_at(7.3, 2.0), size_m=size, yaw_deg=yaw_deg)
        return _world(boxes=(box,))

    assert _front_range(board(7.3)) == pytest.approx(1.99, abs=TOL_M)
    assert np.isinf(_front_range(board(7.3 + 45.0)))


def test_turning_robot_and_post_together_changes_nothing() -> None:
    ranges = []
    for yaw in (0.0, 37.0, -120.0):
        c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
        x, y = _at(6.1, 2.0)
        post = Column(name="post", center_m=(c * x - s * y, s * x + c * y), radius_m=0.02)
        ranges.append(_front_range(_world(yaw_deg=yaw, columns=(post,))))
    assert ranges == pytest.approx([1.98] * 3, abs=TOL_M)
