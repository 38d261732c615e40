"""docs/worlds.md and its pictures: every world of sim_bridge, and what each sensor makes of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from _docs_pictures import write_small
from _docs_sensor_text import sensor_text
from floornav_common.reporting import UserError, say, write_atomic
from sim_bridge.world import World, load_world, world_names

PAGE, FOLDER = "worlds.md", "pictures/worlds"
MAX_FOLDER_BYTES = 2_000_000
_SIDE_PX = 1150
_SEED = 0
_RECORDING = "pedestrians/seq_hotel/obsmat.txt.gz"
SENSOR_PICTURES = ("laser_at_glass.png", "sonar_at_glass.png", "mirror.jpg", "stereo_pair.jpg")


@dataclass(frozen=True)
class Shown:
    """A world on the page.

    Attributes:
        name: As commands take it.
        purpose: What it is for, one sentence.
        look: What to look for in the picture.
        kind: How it is drawn: `ranges`, `drive`, `mirrors`, `stereo`.
        drive_s: How long it was driven before a picture of kind `drive`.
    """

    name: str
    purpose: str
    look: str
    kind: str = "ranges"
    drive_s: float = 6.0

    @property
    def picture(self) -> str:
        """File name of its picture."""
        ending = "jpg" if self.kind in ("mirrors", "stereo") else "png"
        return f"{self.name.replace(':', '-')}.{ending}"


SHOWN = (
    Shown("furnished_floor", "Six furnished rooms on a corridor, for mapping.",
          "No glass. Tables are legs to the laser. Arcs beyond a wall are longer echoes: walls "
          "at a slant reflect sound like mirrors."),
    Shown("glass_corridor", "The glass paper's first place: an L-shaped corridor with an acrylic "
          "board before a niche.",
          "The laser looks through the board and maps the niche; the sonars hear the board."),
    Shown("glass_wall", "The glass paper's second place: a glass wall with posts.",
          "The laser sees the posts and the room behind, the sonars the panes and posts."),
    Shown("flat", "A furnished flat with a glass balcony door, a glazed kitchen and a showcase.",
          "Laser points on the balcony and behind the kitchen's glass."),
    Shown("flat_day", "That flat with people in it, goals, and a robot with "
          "every sensor.", "Three of the people step aside; the one in the living room looks at a "
          "telephone.", "drive", 6.0),
    Shown("office", "An office floor with glass fronts and corridors in a loop, 25 x 18 m, for "
          "long drives.", "Meeting room and front offices are behind glass."),
    Shown("generated:7:0.3", "Floors drawn by seed, `generated:SEED:GLASS_SHARE`, for statistics "
          "over many floors.", "This one has 30 % of its inner walls in glass."),
    Shown("small_size_field", "The floor paper's field and robot: omnidirectional drive, mirror.",
          "The image is in a mirror: front is right, left is below. The robot's own body fills the "
          "middle, straight lines bulge, the walls are a ring.", "mirrors"),
    Shown("middle_size_field", "The team paper's field: four robots with cones that see each "
          "other.", "This mirror sees to 15 degrees above the horizon: goals and the magenta cones "
          "of the teammates.", "mirrors"),
    Shown("stereo_room", "The stereo paper's textured room, 5.12 x 5.12 x 2.56 m, with a front and "
          "a rear pair of cameras.", "Left and right images differ by the disparity. Places that "
          "half a turn about the middle takes into each other look alike, but for a few things.",
          "stereo"),
    Shown("sjmc_static", "SJMC thesis 5.2.2: a static obstacle in the robot's way.",
          "The laser reaches 4 m: the shaded area ends there.", "drive", 1.0),
    Shown("sjmc_crossing", "SJMC thesis 5.2.3: a person crosses the robot's way and does not heed "
          "it.", "The person set out when the robot came within `distance_m`.", "drive", 5.2),
    Shown("sjmc_oncoming", "SJMC thesis 5.2.4: a person comes towards the robot and, once they "
          "have noticed it, steps aside.", "The person's way bends off the robot's.", "drive", 5.0),
    Shown("crowd", "A hall with pillars and walkers who step aside, most of them.",
          "Filled: who has noticed the robot. Dotted: ways so far.", "drive", 6.0),
    Shown("recorded_hotel", "People recorded before a hotel, replayed; they do not react.",
          "The recording is not part of the package: its path is the figure `file`.", "drive", 3.0),
    Shown("fleet", "Eight robots with laser, each in its own namespace.",
          "They see each other: points on outlines.", "drive", 5.0),
)  # fmt: skip


def make_worlds(docs: Path, data: Path) -> None:
    """Draw every world and sensor, and write the page.

    Raises:
        UserError: If the pictures together are too large.
    """
    missing = set(world_names()) - {shown.name for shown in SHOWN}
    if missing:
        raise UserError(f"worlds that the page does not show: {', '.join(sorted(missing))}")
    folder = docs / FOLDER
    for shown in SHOWN:
        _draw_world(shown, folder, data)
    _draw_sensors(folder)
    total = sum(path.stat().st_size for path in folder.iterdir())
    if total > MAX_FOLDER_BYTES:
        raise UserError(f"{folder} holds {total / 1e6:.1f} MB; at most 2 MB are wanted")
    write_atomic(docs / PAGE, worlds_page())
    say(f"written: {docs / PAGE}; its pictures are {total / 1e6:.2f} MB")


def pictures_amiss(docs: Path) -> list[str]:
    """Return what is wrong with the page's pictures: missing, or not on it, or too large."""
    wanted = {shown.picture for shown in SHOWN} | set(SENSOR_PICTURES)
    there = {path.name: path.stat().st_size for path in (docs / FOLDER).glob("*")}
    amiss = [f"{name} is missing" for name in sorted(wanted - set(there))]
    amiss += [f"{name} is on no page" for name in sorted(set(there) - wanted)]
    if sum(there.values()) > MAX_FOLDER_BYTES:
        amiss.append("the pictures are larger than 2 MB")
    return amiss


def worlds_page() -> str:
    """Return the text of docs/worlds.md."""
    parts = [_HEAD, *(_section(shown) for shown in SHOWN), sensor_text(FOLDER)]
    return "\n".join(part.strip() + "\n" for part in parts)


def _section(shown: Shown) -> str:
    run = "python3 scripts/run_node.py sim_bridge sim_bridge --ros-args"
    return (
        f"## {shown.name}\n\n{shown.purpose} {shown.look}\n\n"
        f"![{shown.name}]({FOLDER}/{shown.picture})\n\n"
        f"```\npython3 scripts/demo.py {shown.name} --headless\n"
        f"{run} -p world:={shown.name}\n```\n"
    )


def _draw_world(shown: Shown, folder: Path, data: Path) -> None:
    figures = {}
    if shown.name == "recorded_hotel":
        if not (data / _RECORDING).exists():
            say(f"passed over, not there: {data / _RECORDING}")
            return
        figures["file"] = str(data / _RECORDING)
    world = load_world(shown.name, figures)
    say(f"drawing {shown.name} ...")
    _keep(folder / shown.picture, lambda path: _draw(shown, world, path))


def _draw(shown: Shown, world: World, path: Path) -> None:
    from _docs_world_pictures import write_drive, write_mirrors, write_stereo
    from sim_bridge.world_picture import write_world_picture

    if shown.kind == "ranges":
        write_world_picture(path, world, _SEED)
    elif shown.kind == "drive":
        write_drive(path, world, shown.drive_s, _SEED)
    else:
        (write_mirrors if shown.kind == "mirrors" else write_stereo)(path, world, _SEED)


def _draw_sensors(folder: Path) -> None:
    from _docs_camera_pictures import write_mirror, write_stereo_pair
    from _docs_range_pictures import write_laser, write_sonar

    laser, sonar, mirror, pair = (folder / name for name in SENSOR_PICTURES)
    _keep(laser, lambda path: write_laser(path, path.parent, _SEED))
    _keep(sonar, lambda path: write_sonar(path, path.parent, _SEED))
    _keep(mirror, lambda path: write_mirror(path, _SEED))
    _keep(pair, lambda path: write_stereo_pair(path, _SEED))


def _keep(target: Path, draw: Callable[[Path], None]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawn.png"
        draw(path)
        write_small(path, target, _SIDE_PX)


_HEAD = """
# Worlds and sensors of the simulator

Every world of `sim_bridge`, and every sensor, as its robots meet them. All pictures come from the
simulation itself, without ROS, with seed 0: `python3 scripts/make_docs.py worlds`. A world of
your own is drawn the same way by `python3 scripts/draw_world.py my_room.yaml`; how to write one:
[simulated-world.md](simulated-world.md#your-own-floor).

Each world takes two commands. The first runs it (worlds with a route for one robot with a laser
are mapped, the robots of the others are driven by a script) and leaves a report with pictures, a
summary and a bag; the second only simulates and waits for your `cmd_vel`. With ROS installed the
second is `ros2 run sim_bridge sim_bridge --ros-args -p world:=NAME`.

In pictures with two panels the left or upper one shows the laser, the other one the sonars, taken
at several places of the route; beams and cones of one of them are drawn whole. Beams that came
back without a range are left out.
"""
