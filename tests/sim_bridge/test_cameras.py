"""Cameras in tiny worlds: eq. 26 in the picture, sides, disparity, the engine's own view, bytes."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from camera_worlds import CLEAN, FLAT_LIGHT, edge_radius, ring_world

from floornav_common.camera_files import load_camera
from floornav_common.cameras.hyperboloidal_mirror import paper_camera
from floornav_common.se2 import SE2
from sim_bridge import robot_model
from sim_bridge.appearance import Light
from sim_bridge.drive import Velocity
from sim_bridge.robot_model import load_robot
from sim_bridge.schema import WorldError
from sim_bridge.simulation import Simulation
from sim_bridge.world import Column, Furniture, RobotPlacement, Wall, World, load_world

TOL_PX = 0.1
STILL = Velocity(0.0, 0.0)


def _seen(simulation: Simulation, num_steps: int = 10) -> list:
    name = next(iter(simulation.models))
    return [simulation.step({name: STILL}).robots[name] for _ in range(num_steps)]


def _omni(simulation: Simulation) -> np.ndarray:
    return next(seen.omni for seen in _seen(simulation) if seen.omni is not None)


@pytest.mark.parametrize("size", [(256, 220), (640, 480)])
def test_edges_on_the_floor_are_where_equation_26_puts_them(simulate, size) -> None:
    camera = paper_camera().resized(*size)
    distances = (0.2, 0.3, 0.45, 0.65, 0.9, 1.2, 1.6)
    image = _omni(simulate(ring_world(distances, {"width_px": size[0], "height_px": size[1]})))
    for distance in distances:
        R = float(camera.floor_radius(distance))
        assert float(camera.floor_distance(R)) == pytest.approx(distance)
        found = edge_radius(image, (camera.center_u_px, camera.center_v_px), R)
        assert found == pytest.approx(R, abs=TOL_PX), distance


def test_an_object_on_the_left_is_below_in_the_image(simulate) -> None:
    # Eq. 3: the bearing in the image, with Y running down, is that on the floor.
    world = ring_world((0.3, 0.5), {}, SE2(1.0, 2.0, math.radians(30.0)))
    bearing = math.radians(30.0 + 70.0)
    place = (1.0 + 0.6 * math.cos(bearing), 2.0 + 0.6 * math.sin(bearing))
    red = Column(name="post", center_m=place, radius_m=0.02, height_m=0.1, color=(1.0, 0.0, 0.0))
    image = _omni(simulate(replace(world, columns=(red,)))).astype(int)
    v, u = np.nonzero((image[:, :, 0] > 150) & (image[:, :, 1] < 60))
    is_far = np.hypot(u - 127.5, v - 109.5) > 60.0  # the robot has a red mark of its own
    v, u = v[is_far], u[is_far]
    assert len(u) > 10
    assert math.atan2(v.mean() - 109.5, u.mean() - 127.5) == pytest.approx(
        math.radians(70.0), abs=0.02
    )


def test_the_robot_is_in_the_middle_and_nothing_outside_the_mirror(simulate) -> None:
    image = _omni(simulate(ring_world((0.5,), {})))
    v, u = np.mgrid[:220, :256]
    radius = np.hypot(u - 127.5, v - 109.5)
    assert image[radius > 112.0].max() == 0
    # Rim of the body, radius 85 mm at 90 mm height, hides the floor up to a distance by hand.
    hidden = 0.085 * 0.20508 / (0.20508 - 0.09)
    R = float(paper_camera().floor_radius(hidden))
    assert (image[radius < R - 1.5].max(axis=-1) < 200).all()
    assert image[np.abs(radius - R - 2.0) < 0.7].min() > 150


def test_moving_world_and_robot_together_changes_no_image(simulate) -> None:
    world = ring_world((0.3, 0.5), {})
    images = [_omni(simulate(world, T_new_old=T)) for T in (None, SE2(3.0, -2.0, 1.1))]
    difference = np.abs(images[0].astype(int) - images[1].astype(int))
    assert (difference > 1).mean() < 1e-3


def test_same_seed_gives_the_same_images_and_reset_brings_them_back(simulate) -> None:
    worlds = [load_world("small_size_field") for _ in range(2)]
    simulations = [simulate(world, seed=5) for world in worlds]
    first, second = (_seen(s, 20) for s in simulations)
    images = [
        [seen.omni.tobytes() for seen in run if seen.omni is not None] for run in (first, second)
    ]
    assert images[0] == images[1] and len(images[0]) == 2 and images[0][0] != images[0][1]
    simulations[0].reset()
    again = [seen.omni.tobytes() for seen in _seen(simulations[0], 20) if seen.omni is not None]
    assert again == images[0]
    assert _omni(simulate(worlds[0], seed=6)).tobytes() != images[0][0]


def _two_cameras() -> World:
    mirror = RobotPlacement(model="soccer_small_size", name="mirror", position_m=(1.0, 1.0))
    world = load_world("stereo_room")
    return replace(world, robots=(*(replace(r, name="pairs") for r in world.robots), mirror))


def test_an_image_that_nobody_watches_changes_nothing_else(simulate) -> None:
    """Byte for byte: other cameras, later images of the same one, every other sensor."""
    every, some = (simulate(_two_cameras(), seed=3) for _ in range(2))
    asked = []

    def is_watched(robot: str, camera: str) -> bool:
        asked.append((some.stamp_ns, robot, camera))
        return some.stamp_ns > 250_000_000 or camera == "front"

    num_images = 0
    for _ in range(40):
        drive = dict.fromkeys(every.models, Velocity(0.2, 0.3))
        a, b = every.step(drive), some.step(drive, is_watched)
        is_late = a.stamp_ns > 250_000_000
        for name in ("pairs", "mirror"):
            full, part = a.robots[name], b.robots[name]
            assert part.ground_truth == full.ground_truth and part.sonar == full.sonar
            assert (part.scan is None) == (full.scan is None)
            if full.scan is not None:
                assert part.scan.ranges.tobytes() == full.scan.ranges.tobytes()
            if full.omni is not None:
                assert (part.omni is not None) == is_late
                assert not is_late or part.omni.tobytes() == full.omni.tobytes()
            for pair, images in (full.stereo or {}).items():
                assert (pair in part.stereo) == (is_late or pair == "front")
                for side in ("left", "right") if pair in part.stereo else ():
                    own, other = getattr(part.stereo[pair], side), getattr(images, side)
                    assert own.tobytes() == other.tobytes()
                    num_images += 1
    assert num_images == 2 * (4 + 2)
    # Asked only when an image is due.
    assert len(asked) == 4 * 3 and {stamp for stamp, _, _ in asked} == {
        100_000_000, 200_000_000, 300_000_000, 400_000_000,
    }  # fmt: skip


def test_images_of_one_scene_differ_in_their_noise_alone(simulate) -> None:
    simulation = simulate(load_world("small_size_field"))
    first, second = (s.omni.astype(int) for s in _seen(simulation, 20) if s.omni is not None)
    difference = (first - second)[second.max(axis=2) > 20]
    # Two images' noise: 2 levels in the dark, 0.15 per level more, in both.
    assert abs(difference.mean()) < 0.2
    assert 1.4 * 2.0 < difference.std() < 1.4 * math.sqrt(4.0 + 0.15 * 255.0)


def _stereo_world(light: Light = FLAT_LIGHT) -> World:
    wall = Wall(from_m=(3.05, -3.0), to_m=(3.05, 3.0), thickness_m=0.1, color=(0.2, 0.2, 0.2))
    post = Column(name="post", center_m=(1.97, 0.1), radius_m=0.03, color=(1.0, 1.0, 1.0))
    box = Furniture(name="box", center_m=(2.0, -0.6), size_m=(0.3, 0.4, 1.1), color=(0.9, 0.2, 0.1))
    robot = RobotPlacement(
        model="segway_stereo", position_m=(0.0, 0.0), overrides={"stereo": {"image": CLEAN}}
    )
    return World(
        name="stereo", walls=(wall,), columns=(post,), boxes=(box,), robots=(robot,), light=light
    )


def test_disparity_of_a_post_is_focal_length_times_baseline_over_depth(simulate) -> None:
    overrides = {"stereo": {"image": CLEAN, "samples": 4, "refine_above": -1.0}}  # finer than a px
    world = _stereo_world()
    fine = replace(world, robots=(replace(world.robots[0], overrides=overrides),))
    simulation = simulate(fine)
    pair = next(seen.stereo for seen in _seen(simulation) if seen.stereo is not None)["front"]
    model = simulation.models[""]
    assert model.baseline("front") == pytest.approx(0.10)
    middles = []
    for image in (pair.left, pair.right):
        row = image[100].astype(float).min(axis=1)
        row[row < 80.0] = 0.0
        middles.append((row * np.arange(len(row))).sum() / row.sum())
    focal = model.config.stereo.focal_px
    depth = math.hypot(1.97 + 0.11, 0.0)  # the camera is 0.11 m behind base_link
    assert middles[0] - middles[1] == pytest.approx(focal * 0.10 / depth, abs=0.15)
    # Left of the left camera's axis (y = 0.05) by 0.05 m: so many pixels left of the middle.
    assert middles[0] == pytest.approx(159.5 - focal * 0.05 / depth, abs=0.3)


def test_the_picture_agrees_with_the_engines_own(simulate) -> None:
    """Same eye, same target: shapes cover the same pixels as in pybullet's renderer."""
    simulation = simulate(_stereo_world())
    eye, target, size = (-1.0, -1.5, 1.6), (2.2, 0.0, 0.4), (320, 240)
    ours = simulation.views.picture(eye, target, size, up=(0.0, 0.0, 1.0)).astype(int)
    theirs = simulation._physics.picture(eye, target, size, up=(0.0, 0.0, 1.0)).astype(int)
    for is_in in (
        lambda p: (p[..., 0] > 1.8 * p[..., 1]) & (p[..., 0] > 60),  # the red box
        lambda p: (p[..., 2] > 1.6 * p[..., 0]) & (p[..., 2] > 50),  # the robot's blue laser
    ):
        a, b = is_in(ours), is_in(theirs)
        assert a.sum() > 20 and (a != b).sum() < 0.12 * a.sum() + 10


def test_shadow_light_and_color_act_as_asked(simulate) -> None:
    def mean(light: Light) -> np.ndarray:
        seen = next(s for s in _seen(simulate(_stereo_world(light))) if s.stereo is not None)
        return np.asarray(seen.stereo["front"].left.reshape(-1, 3).mean(axis=0))

    plain = mean(Light(shadow=0.0))
    assert (mean(Light(shadow=1.0)) < plain).all()
    tinted = mean(Light(shadow=0.0, color=(1.0, 0.5, 0.5)))
    assert tinted[0] == pytest.approx(plain[0], rel=0.01)
    # An even gray takes a whole level, up to half of one off.
    assert tinted[1:] == pytest.approx(plain[1:] / 2.0, abs=0.5)


@pytest.mark.parametrize("name", ["soccer_small_size", "soccer_middle_size"])
def test_camera_files_are_those_of_the_robots(name: str) -> None:
    robot = load_robot(RobotPlacement(model=name, position_m=(0.0, 0.0)))
    path = Path(robot_model.__file__).parent / "camera_models" / f"{name}.yaml"
    assert robot.config.omni is not None
    assert load_camera(path) == robot.config.omni.camera()


def test_middle_size_mirror_sees_fifteen_degrees_above_the_horizon() -> None:
    robot = load_robot(RobotPlacement(model="soccer_middle_size", position_m=(0.0, 0.0)))
    assert robot.config.omni is not None
    camera = robot.config.omni.camera()
    assert camera.viewpoint_height == pytest.approx(0.6)
    assert math.degrees(camera.elevation(camera.max_radius_px)) == pytest.approx(15.0)
    assert camera.max_radius_px < min(camera.center_u_px, camera.center_v_px)


def test_a_mirror_elsewhere_than_its_figures_say_is_refused() -> None:
    placement = RobotPlacement(
        model="soccer_small_size", position_m=(0.0, 0.0), overrides={"omni": {"a_px_per_mm": 10.3}}
    )
    with pytest.raises(WorldError, match="viewpoint"):
        load_robot(placement)


def test_the_number_of_threads_changes_no_byte(simulate) -> None:
    world = load_world("small_size_field")
    images = [_omni(simulate(world, num_threads=n)).tobytes() for n in (1, 2)]
    assert images[0] == images[1]
