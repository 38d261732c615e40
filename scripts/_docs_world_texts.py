"""What docs/world-files.md says beside the dataclasses: examples, and meanings of plain keys."""

from __future__ import annotations

HEAD = """\
# World files

Written by `python3 scripts/make_docs.py world-files` from the dataclasses that read the files; do
not edit by hand. A first world, and how to run it:
[simulated-world.md](simulated-world.md#your-own-floor); pictures of all that are there:
[worlds.md](worlds.md).

Lengths are meters, angles degrees, colors red, green, blue from 0 to 1. x points right, y up on
the plan, z up from the floor. A key without default is required; an unknown key is refused in one
line that names those there are. Each example is a part of a file and can be copied as it is.
"""

EXAMPLES = {
    "Top level": """
name: my_room
description: One room with a robot
parameters: {start_x: 1.0}   # figures to be set from outside: --set start_x=2, used as $start_x
walls:
  - {from_m: [0, 0], to_m: [6, 0]}
robots:
  - {model: segway_rmp50, position_m: [$start_x, 1]}
""",
    "walls": """
walls:
  - {from_m: [0, 0], to_m: [6, 0], thickness_m: 0.2, texture: bricks}
  - {from_m: [6, 0], to_m: [6, 4], glass: {}, frame: {spacing_m: 1.2}}
""",
    "doors": """
walls:
  - from_m: [3, 0]
    to_m: [3, 4]
    doors:
      - {at_m: 1.0}
      - {at_m: 3.0, width_m: 1.2, glass: {thickness_m: 0.01}, frame: {rail_m: 0.08}}
""",
    "glass": """
walls:
  - {from_m: [0, 2], to_m: [6, 2], glass: {transmission: 0.85, scatter_share: 0.05}}
""",
    "frame": """
walls:
  - {from_m: [0, 2], to_m: [6, 2], glass: {}, frame: {spacing_m: 1.21, rail_m: 0.08}}
""",
    "boxes, tables, shelves": """
boxes:
  - {name: sofa, center_m: [0.6, 3.2], size_m: [0.9, 1.4, 0.8], yaw_deg: 10, surface: cloth}
  - {name: showcase, center_m: [3.0, 3.2], size_m: [1.0, 0.5, 1.8], glass: {}}
tables:
  - {name: desk, center_m: [5.2, 3.3], size_m: [1.2, 0.7, 0.74]}
shelves:
  - {name: books, center_m: [0.2, 1.0], size_m: [0.3, 1.4, 1.9], texture: books}
""",
    "columns": """
columns:
  - {name: pillar, center_m: [4.5, 0.8], radius_m: 0.2, surface: dark}
""",
    "balls": """
balls:
  - {center_m: [2.0, 1.0], radius_m: 0.11, mass_kg: 0.4}
""",
    "robots": """
robots:
  - {name: r1, model: segway_rmp50, position_m: [1, 1]}
  - name: r2
    model: segway_urg
    position_m: [1, 3]
    yaw_deg: 90
    overrides: {laser: {num_beams: 1081}, wheels: {slip_mean: 0.05}}
""",
    "route": """
route:
  speed_m_s: 0.6
  waypoints_m: [[1.5, 1.2], [2.2, 2.0], [3.8, 2.0]]
""",
    "goals": """
goals:
  speed_m_s: 0.6
  points_m: [[2.9, 1.2], [7.4, 1.2]]
""",
    "floor": """
floor:
  color: [0.10, 0.42, 0.20]
  from_m: [0, 0]
  to_m: [6, 4]
  texel_m: 0.005
  areas: [{from_m: [0, 1], to_m: [0.5, 3], color: [0.9, 0.8, 0.1]}]
  lines: [{from_m: [3, 0], to_m: [3, 4], width_m: 0.03}]
  rings: [{center_m: [3, 2], radius_m: 0.6, width_m: 0.03}]
  dirt: {count: 40}
""",
    "light": """
light: {direction: [1.0, 0.2, 0.8], color: [1.0, 0.9, 0.7], ambient: 0.3, shadow: 0.8}
""",
    "measures": """
measures:
  - {name: a, from_m: [3.0, 0.0], to_m: [3.0, 4.0], doc: width of the room}
  - {name: b, from_m: [0.0, 4.0], corner_m: [0.0, 0.0], to_m: [6.0, 0.0], doc: a right angle}
""",
    "people": """
people:
  - {name: guard, path_m: [[1, 1], [5, 1]], speed_m_s: 1.0, repeats: true}
  - {name: visitor, path_m: [[5, 3], [1, 3]], starts_within_m: 3.0, is_reacting: true}
""",
    "crowd": """
crowd: {num: 12, low_m: [0.5, 0.5], high_m: [11.5, 7.5]}
""",
    "recorded_people": """
recorded_people: {file: obsmat.txt, starts_s: 375.0, low_m: [-4, -10], high_m: [5, 4]}
""",
    "people_model": """
people_model: {never_share: 0.3, notice_distance_m: 3.0}
""",
}
"""A part of a world file for each heading; a test builds them all."""

MEANINGS: dict[str, dict[str, str]] = {
    "anywhere": {
        "name": "Name, for reports and errors.",
        "color": "Color.",
        "texture": "How cameras see it: see [surface and texture](#surface-and-texture).",
        "surface": "What it is to sonar and laser: see "
        "[surface and texture](#surface-and-texture).",
        "yaw_deg": "Turn counter-clockwise.",
        "mass_kg": "Mass; 0 = fixed, else it can be pushed.",
        "radius_m": "Radius.",
        "height_m": "Height, from the floor.",
        "center_m": "Middle, on the floor.",
        "from_m": "First end or corner.",
        "to_m": "Other end or corner.",
        "width_m": "Width.",
        "doc": "What it is, in words.",
    },
    "Top level": {
        "name": "Name, for folders and reports.",
        "description": "One line, for reports.",
        "walls": "Straight walls, of plaster or glass.",
        "boxes": "Closed boxes.",
        "tables": "Tops on four legs: a laser below sees the legs only.",
        "shelves": "Boxes open to their +x side.",
        "columns": "Upright cylinders.",
        "balls": "Balls on the floor.",
        "floor": "What the floor looks like to cameras.",
        "light": "The lamp, for cameras.",
        "ceiling_m": "Height of a ceiling that cameras see; none = open.",
        "robots": "Robots and where they start.",
        "route": "What the demo drives, steered by a script.",
        "goals": "Where the demo sends the robot, driven by the planner.",
        "measures": "Named lengths and angles, to compare a map with.",
        "people": "People with a plan each.",
        "crowd": "Walkers drawn by seed.",
        "recorded_people": "People replayed from a recording.",
        "people_model": "How all of them notice and yield.",
        "parameters": "Figures by name with their defaults: `$name` anywhere in the file stands "
        "for one, `--set name=value` and `world_parameters` replace it.",
    },
    "walls": {
        "from_m": "Start of the middle line.",
        "to_m": "End of the middle line.",
        "thickness_m": "Thickness; of a glass wall that of the glass counts.",
        "doors": "Openings.",
        "glass": "Makes it a row of panes.",
        "frame": "Posts and rails that hold the panes.",
    },
    "doors": {
        "at_m": "Middle, measured along the wall from its start.",
        "glass": "Closes the opening by a pane.",
        "frame": "Posts and rails that hold the pane.",
    },
    "boxes, tables, shelves": {
        "size_m": "Along its own x, y and z.",
        "glass": "Boxes only: a case of four panes.",
    },
    "robots": {
        "model": "A file in `sim_bridge/robots`: [which there are](parameters.md#robots).",
        "position_m": "Where `base_link` starts.",
        "name": "Namespace of its topics; only a single robot needs none.",
        "overrides": "Keys of the [robot file](parameters.md#robot-files) to change.",
    },
    "route": {
        "waypoints_m": "Points in the world, driven in order.",
        "speed_m_s": "Travel speed.",
    },
    "goals": {
        "points_m": "Places in the world, one after the other.",
        "speed_m_s": "Travel speed.",
    },
    "floor": {
        "from_m": "Lower corner of the painted part.",
        "to_m": "Its upper corner; the same as `from_m` = nothing is painted.",
        "areas": "Painted rectangles.",
        "lines": "Painted lines.",
        "rings": "Painted circle lines.",
        "dirt": "Stains.",
    },
    "rings": {"radius_m": "Radius of the line's middle.", "width_m": "Width of the line."},
    "lines": {"width_m": "Width of the line."},
    "dirt": {"count": "Number of stains.", "size_m": "Their size.", "seed": "Seed of places."},
    "measures": {
        "from_m": "First point.",
        "to_m": "Second point.",
        "corner_m": "With it the angle there between both is meant, else their distance.",
    },
    "crowd": {
        "num": "Number of people.",
        "low_m": "Lower corner of the rectangle they walk in.",
        "high_m": "Its upper corner.",
        "num_goals": "Places they walk between.",
        "free_m": "Distance of these places from things.",
    },
}  # fmt: skip
"""By heading and key, for keys whose classes say nothing of them; "anywhere" for the rest."""
