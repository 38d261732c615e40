"""A world as data: walls with doors, furniture, robots and a route (schema of the YAML files).

Lengths are metres, angles degrees (people write these files); everything else in the package is
SI. Every key is a field below; a field without default is required; unknown keys are refused.
`surface` names a material of `sim_bridge.surfaces`: "" = as its texture or kind of thing is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from floornav_common.se2 import SE2
from sim_bridge.appearance import Floor, Light
from sim_bridge.glass import Frame, Glass
from sim_bridge.measures import Measure
from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.schema import Crowd, Recording, WalkerPlan
from sim_bridge.places import Goals
from sim_bridge.places import Route as Route
from sim_bridge.schema import WorldError, build, filled_in, load_yaml
from sim_bridge.surfaces import require_looks

Point = tuple[float, float]
Size = tuple[float, float, float]
Color = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Door:
    """An opening in a wall; `at_m` is its middle, measured from the wall's start.

    With `glass` it is closed by a pane, in a `frame` if one is given.
    """

    at_m: float
    width_m: float = 0.95
    glass: Glass | None = None
    frame: Frame | None = None


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A straight upright wall along its middle line, with openings.

    With `glass` it is a row of panes, as thick as the glass, in a `frame` if one is given.
    """

    from_m: Point
    to_m: Point
    thickness_m: float = 0.12
    height_m: float = 2.4
    color: Color = (0.87, 0.85, 0.80)
    doors: tuple[Door, ...] = ()
    glass: Glass | None = None
    frame: Frame | None = None
    texture: str = ""
    surface: str = ""

    def __post_init__(self) -> None:
        require_looks(self.texture, self.surface)
        if self.length < 1e-6:
            raise ValueError(f"the wall at {list(self.from_m)} has zero length")
        _require_positive(thickness_m=self.thickness_m, height_m=self.height_m)
        parts: tuple[Wall | Door, ...] = (self, *self.doors)
        for part in parts:
            if part.frame is not None and part.glass is None:
                raise ValueError("a frame needs glass in it")
            if part.frame is not None and 2.0 * part.frame.rail_m >= self.height_m:
                raise ValueError("the rails of the frame leave no glass")
        end = 0.0
        for door in sorted(self.doors, key=lambda door: door.at_m):
            _require_positive(width_m=door.width_m)
            if door.at_m - door.width_m / 2 < end or door.at_m + door.width_m / 2 > self.length:
                raise ValueError(f"the door at {door.at_m} m overlaps another or leaves the wall")
            end = door.at_m + door.width_m / 2

    @property
    def length(self) -> float:
        """Length of the middle line, m."""
        return math.dist(self.from_m, self.to_m)


@dataclass(frozen=True, kw_only=True)
class Furniture:
    """A box, table (top on four legs) or shelf (open to its +x side): one bounding box each.

    A box may be of `glass`: a case of four panes, such as a showcase.
    """

    name: str
    center_m: Point
    size_m: Size
    yaw_deg: float = 0.0
    mass_kg: float = 0.0
    color: Color = (0.72, 0.53, 0.35)
    glass: Glass | None = None
    texture: str = ""
    surface: str = ""

    def __post_init__(self) -> None:
        require_looks(self.texture, self.surface)
        _require_positive(**{f"size_m[{k}]": value for k, value in enumerate(self.size_m)})
        if self.mass_kg < 0.0:
            raise ValueError(f"mass_kg must be >= 0 (0 = fixed), got {self.mass_kg}")


@dataclass(frozen=True, kw_only=True)
class Column:
    """An upright cylinder."""

    name: str
    center_m: Point
    radius_m: float
    height_m: float = 2.4
    mass_kg: float = 0.0
    color: Color = (0.75, 0.75, 0.78)
    texture: str = ""
    surface: str = ""

    def __post_init__(self) -> None:
        require_looks(self.texture, self.surface)
        _require_positive(radius_m=self.radius_m, height_m=self.height_m)


@dataclass(frozen=True, kw_only=True)
class Ball:
    """A ball on the floor."""

    name: str = "ball"
    center_m: Point
    radius_m: float
    mass_kg: float = 0.0
    color: Color = (0.95, 0.45, 0.05)

    def __post_init__(self) -> None:
        _require_positive(radius_m=self.radius_m)


@dataclass(frozen=True, kw_only=True)
class RobotPlacement:
    """One robot: its name ("" for the only one), its file in `robots/`, and where it starts.

    `overrides` changes keys of the robot file, such as `{laser: {num_beams: 1081}}`.
    """

    model: str
    position_m: Point
    yaw_deg: float = 0.0
    name: str = ""
    overrides: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.name and not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", self.name):
            raise ValueError(
                f"name must be letters, digits and _, a letter first (it becomes a namespace), "
                f"got {self.name!r}"
            )

    @property
    def pose(self) -> SE2:
        """Start pose in the world."""
        return SE2(*self.position_m, math.radians(self.yaw_deg))


@dataclass(frozen=True, kw_only=True)
class World:
    """Everything a simulation is built from."""

    name: str
    description: str = ""
    walls: tuple[Wall, ...] = ()
    boxes: tuple[Furniture, ...] = ()
    tables: tuple[Furniture, ...] = ()
    shelves: tuple[Furniture, ...] = ()
    columns: tuple[Column, ...] = ()
    balls: tuple[Ball, ...] = ()
    floor: Floor = Floor()
    light: Light = Light()
    ceiling_m: float | None = None
    robots: tuple[RobotPlacement, ...] = ()
    route: Route | None = None
    goals: Goals | None = None
    measures: tuple[Measure, ...] = ()
    people: tuple[WalkerPlan, ...] = ()
    crowd: Crowd | None = None
    recorded_people: Recording | None = None
    people_model: PeopleConfig = PeopleConfig()
    parameters: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _require_positive(ceiling_m=1.0 if self.ceiling_m is None else self.ceiling_m)
        for item in (*self.tables, *self.shelves):
            if item.glass is not None:
                raise ValueError(f"{item.name!r} cannot be of glass: only walls, doors and boxes")
        for kind, named in (("robots", self.robots), ("people", self.people)):
            names = [one.name for one in named]
            for name in (name for name in names if names.count(name) > 1):
                text = (
                    f"two {kind} have the name {name!r}" if name else f"several {kind} need names"
                )
                raise ValueError(text)


def world_names() -> list[str]:
    """Return the names of the worlds in the package, sorted."""
    folder = resources.files("sim_bridge") / "worlds"
    return sorted(f.name[: -len(".yaml")] for f in folder.iterdir() if f.name.endswith(".yaml"))


def load_world(name_or_path: str | Path, parameters: Mapping[str, Any] | None = None) -> World:
    """Load a world of the package by name, or any YAML file by path.

    A file may name figures under `parameters` and use them as `$name`; those given here replace
    the file's. `generated:SEED:GLASS_SHARE` is a floor made by `sim_bridge.generator`.

    Raises:
        WorldError: If there is none of that name or the file does not hold to the schema.
    """
    if str(name_or_path).startswith("generated:"):
        from sim_bridge.generator import generated_world

        return generated_world(str(name_or_path))
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        if str(name_or_path) not in world_names():
            known = ", ".join(world_names())
            raise WorldError(f"no world named {str(name_or_path)!r}; there are: {known}")
        path = Path(str(resources.files("sim_bridge") / "worlds" / f"{name_or_path}.yaml"))
    data = filled_in(load_yaml(path), parameters or {}, path.name)
    return build(World, data, path.name)


def _require_positive(**values: float) -> None:
    for name, value in values.items():
        if not value > 0.0:
            raise ValueError(f"{name} must be > 0, got {value:g}")
