"""Cameras against their models: the mirror's radii beside eq. 26, noise, light; pictures.

`run` gives the rows and pictures of the experiment `sensor-models`; `draw_world` the pictures of
one world for reports.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np

from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera, paper_camera
from sim_bridge.appearance import Floor, Light, Ring
from sim_bridge.drive import Velocity
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, World, load_world

HEADER = ("quantity", "promised", "measured", "deviation", "tolerance", "kept")
_RADIUS_TOL_PX, _DISPARITY_TOL_PX, _GRAY_TOL, _NOISE_TOL = 0.1, 0.1, 1.0, 0.05
WORLDS = ("small_size_field", "middle_size_field", "stereo_room")
_CLEAN = {
    "exposure": 1.0, "blur_sd_px": 0.0, "vignetting": 0.0, "noise_sd": 0.0, "shot_noise": 0.0,
}  # fmt: skip
_SIZES = ((256, 220), (640, 480))
_DISTANCES = (0.20, 0.30, 0.45, 0.65, 0.90, 1.20, 1.60, 2.20)
_WHITE, _BLACK = (0.9, 0.9, 0.9), (0.05, 0.05, 0.05)
Row = tuple[str, str, str, str, str, bool]


def run(seed: int) -> tuple[list[Row], dict[str, np.ndarray]]:
    """Return rows as `HEADER` names them, and pictures (RGB uint8) by name."""
    rows: list[Row] = []
    for size in _SIZES:
        rows += mirror_rows(size, seed)
    rows += [*noise_rows(seed), *light_rows(seed), *disparity_rows(seed)]
    pictures = {
        f"{world}_{name}": picture
        for world in WORLDS
        for name, picture in draw_world(world, seed).items()
    }
    return rows, pictures


def mirror_rows(size: tuple[int, int], seed: int) -> list[Row]:
    """Return the pixel radius of edges on the floor beside eq. 26, at an image size."""
    camera = paper_camera().resized(*size)
    overrides = {"width_px": size[0], "height_px": size[1], "samples": 4, "image": _CLEAN}
    image = _first_omni(_rings(overrides), seed)
    rows = []
    for distance in _DISTANCES:
        R = float(camera.floor_radius(distance))
        found = edge_radii(image, camera, R)
        name = f"mirror {size[0]} x {size[1]}: radius of {distance:.2f} m, px"
        rows.append(_row(name, f"{R:.3f}", f"{found.mean():.3f}", found.mean() - R, _RADIUS_TOL_PX))
    return rows


def noise_rows(seed: int) -> list[Row]:
    """Return the noise of even gray patches beside what the parameters promise."""
    world = replace(_rings({"samples": 1}), floor=Floor(color=(0.5, 0.5, 0.5)))
    still = {"blur_sd_px": 0.0, "vignetting": 0.0, "exposure": 1.0}
    rows = []
    for dark, shot in ((2.0, 0.0), (2.0, 0.15), (5.0, 0.0)):
        image_config = {**still, "noise_sd": dark, "shot_noise": shot}
        world = _with(world, {"image": image_config})
        images = np.array(_omnis(world, seed, 12)).astype(float)
        ring = _between(images[0], 75.0, 100.0)
        promised = math.sqrt(dark**2 + shot * 127.5 + 1.0 / 12.0)
        found = math.sqrt(images[:, ring].var(axis=0, ddof=1).mean())
        name = f"noise at gray 127, dark {dark:g}, shot {shot:g}"
        off, tol = found / promised - 1.0, _NOISE_TOL
        rows.append(_row(name, f"{promised:.2f}", f"{found:.2f}", off, tol, "+.1%"))
    return rows


def light_rows(seed: int) -> list[Row]:
    """Return brightness under exposure, colored light and vignetting beside what is promised."""
    floor = Floor(color=(0.5, 0.5, 0.5))
    rows = []
    for exposure, color in ((1.0, (1.0, 1.0, 1.0)), (0.6, (1.0, 1.0, 1.0)), (1.0, (1.0, 0.8, 0.5))):
        world = _with(_rings({"samples": 1}), {"image": {**_CLEAN, "exposure": exposure}})
        world = replace(world, floor=floor, light=Light(shadow=0.0, color=color))
        image = _first_omni(world, seed)
        found = image[_between(image, 60.0, 100.0)].mean(axis=0)
        promised = 127.5 * exposure * np.array(color)
        off = float(np.abs(found - promised).max())
        name = f"floor of 0.5 at exposure {exposure:g}, light {color}"
        rows.append(_row(name, _rgb(promised), _rgb(found), off, _GRAY_TOL, "+.1f"))
    image = _first_omni(
        replace(_with(_rings({}), {"image": {**_CLEAN, "vignetting": 0.4}}), floor=floor), seed
    )
    found = float(image[_between(image, 99.5, 100.5)].mean())
    promised = 127.5 * (1.0 - 0.4 * (100.0 / 110.0) ** 2)
    name, off = "vignetting 0.4 at 100 px", found - promised
    rows.append(_row(name, f"{promised:.1f}", f"{found:.1f}", off, _GRAY_TOL, "+.1f"))
    return rows


def disparity_rows(seed: int) -> list[Row]:
    """Return the shift of stereo_room's front wall between left and right beside f B / Z."""
    robot = RobotPlacement(
        model="segway_stereo", position_m=(2.6, 2.56), overrides={"stereo": {"image": _CLEAN}}
    )
    world = replace(load_world("stereo_room"), boxes=(), tables=(), robots=(robot,))
    simulation = Simulation(world, seed=seed)
    seen = _steps(simulation, 10)[-1]
    pair, model = seen.stereo["front"], simulation.models[""]
    promised = model.config.stereo.focal_px * model.baseline("front") / (5.12 - 2.6 + 0.11)
    found = _shift(pair.left[60:180], pair.right[60:180])
    simulation.close()
    name, off = "disparity of a wall, px", found - promised
    return [_row(name, f"{promised:.2f}", f"{found:.2f}", off, _DISPARITY_TOL_PX, "+.2f")]


def edge_radii(image: np.ndarray, camera: MirrorCamera, near: float) -> np.ndarray:
    """Return the pixel radius of a step in brightness along 180 directions, (180,)."""
    gray = image.astype(float).mean(axis=2)
    radii = near + np.linspace(-2.5, 2.5, 101)
    found = []
    for angle in np.linspace(0.0, 2.0 * math.pi, 180, endpoint=False):
        u = camera.center_u_px + radii * math.cos(angle)
        v = camera.center_v_px + radii * math.sin(angle)
        values = _bilinear(gray, u, v)
        share = (values - values[0]) / (values[-1] - values[0])
        k = int(np.flatnonzero((share[:-1] < 0.5) & (share[1:] >= 0.5))[0])
        found.append(np.interp(0.5, share[k : k + 2], radii[k : k + 2]))
    return np.array(found)


def draw_world(name: str, seed: int = 0, num_steps: int = 100) -> dict[str, np.ndarray]:
    """Return pictures of a world and its cameras while its robots move, RGB uint8, by name.

    Args:
        name: A world of the package, or a path.
        seed: Of the simulation.
        num_steps: How long its robots drive, in steps of the simulation.
    """
    simulation = Simulation(load_world(name), seed=seed)
    pictures = {}
    for _ in range(num_steps):
        commands = {n: Velocity(0.2, 0.2) for n in simulation.models}
        for robot, seen in simulation.step(commands).robots.items():
            where = f"{robot}_" if robot else ""
            if seen.omni is not None:
                pictures[f"{where}omni"] = seen.omni
            for pair, images in (seen.stereo or {}).items():
                pictures[f"{where}stereo_{pair}"] = np.hstack((images.left, images.right))
    pictures["overview"] = simulation.overview((880, 660))
    simulation.close()
    return pictures


def frame_times(world: World, seed: int = 0, num_frames: int = 20) -> float:
    """Return the processor time of a step that has every camera's image, median, ms."""
    simulation, times = Simulation(world, seed=seed), []
    while len(times) < num_frames + 2:
        started = time.thread_time()
        seen = simulation.step({})
        took = 1e3 * (time.thread_time() - started)
        if any(s.omni is not None or s.stereo is not None for s in seen.robots.values()):
            times.append(took)
    simulation.close()
    return float(np.median(times[2:]))


def _rings(omni: dict[str, object]) -> World:
    """Return a robot amid disks, white and black in turn, whose edges are at `_DISTANCES`."""
    rings = tuple(
        Ring(center_m=(0, 0), radius_m=d / 2, width_m=d, color=_BLACK if k % 2 else _WHITE)
        for k, d in enumerate(sorted(_DISTANCES, reverse=True))
    )
    reach = 1.02 * max(_DISTANCES)
    floor = Floor(
        color=_BLACK, from_m=(-reach, -reach), to_m=(reach, reach), texel_m=reach / 1500.0,
        carpet=0.0, rings=rings,
    )  # fmt: skip
    robot = RobotPlacement(
        model="soccer_small_size", position_m=(0.0, 0.0),
        overrides={"omni": omni},
    )  # fmt: skip
    return World(name="rings", floor=floor, light=Light(shadow=0.0), robots=(robot,))


def _with(world: World, omni: dict[str, object]) -> World:
    robot = world.robots[0]
    merged = {"omni": {**robot.overrides["omni"], **omni}}
    return replace(world, robots=(replace(robot, overrides=merged),))


def _steps(simulation: Simulation, num: int) -> list:
    name = next(iter(simulation.models))
    return [simulation.step({name: Velocity(0.0, 0.0)}).robots[name] for _ in range(num)]


def _omnis(world: World, seed: int, count: int) -> list[np.ndarray]:
    simulation = Simulation(world, seed=seed)
    seen = [s.omni for s in _steps(simulation, 10 * count) if s.omni is not None]
    simulation.close()
    return seen


def _first_omni(world: World, seed: int) -> np.ndarray:
    return _omnis(world, seed, 1)[0]


def _between(image: np.ndarray, low: float, high: float) -> np.ndarray:
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    radius = np.hypot(u - (image.shape[1] - 1) / 2.0, v - (image.shape[0] - 1) / 2.0)
    return np.asarray((radius > low) & (radius < high))


def _bilinear(gray: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    j, i = np.floor(u).astype(int), np.floor(v).astype(int)
    x, y = u - j, v - i
    low = (1 - x) * gray[i, j] + x * gray[i, j + 1]
    top = (1 - x) * gray[i + 1, j] + x * gray[i + 1, j + 1]
    return np.asarray((1 - y) * low + y * top)


def _shift(left: np.ndarray, right: np.ndarray) -> float:
    """Return how far the right image lies to the left of the left one, to a part of a pixel."""
    a, b = left.astype(float).mean(axis=2), right.astype(float).mean(axis=2)
    costs = np.array([np.abs(a[:, 40:] - b[:, 40 - d : b.shape[1] - d]).mean() for d in range(40)])
    k = int(costs.argmin())
    down, up = costs[k - 1] - costs[k], costs[k + 1] - costs[k]
    # Absolute differences make a V about the minimum.
    return k + 0.5 * (down - up) / max(down, up)


def _row(
    name: str, promised: str, measured: str, off: float, tolerance: float, form: str = "+.3f"
) -> Row:
    allowed = format(tolerance, form.lstrip("+"))
    is_kept = bool(abs(off) <= tolerance)  # NaN is not
    return name, promised, measured, format(off, form), allowed, is_kept


def _rgb(values: np.ndarray) -> str:
    return ", ".join(f"{v:.1f}" for v in values)
