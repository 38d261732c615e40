"""The page `docs/faults.md`, written from a run."""

from __future__ import annotations

from experiments.faults_result import Row

_HEAD = """\
# Faults, and what the robot does

Written by `python3 scripts/evaluate.py faults --out DIR` as `DIR/faults.md` from what that run
measured; do not edit by hand. `--list` names the faults, `--only NAME ...` runs some, `--quick` one
of each kind. It ends with 1 if one is not passed.

Each fault strikes in the running graph while the robot drives: every node is a process of its own
over DDS, and a relay of ours stands between the simulator and the nodes, which drops, freezes,
delays, changes or repeats messages on their way. Two graphs are used: `hall`, where the robot
of the [demo with goals](demo.md) maps, plans and drives by laser (`sim_bridge`, `grid_mapper`,
`wavefront_planner`, `local_planner`, `floor_detector`), and `field`, where a small robot has
nothing but its camera to drive by (`sim_bridge`, `floor_detector`, `local_planner`).

How a row is judged:

- By what arrived at the simulator as `cmd_vel` and by how the robot truly moved, never by what a
  node says of itself; where a node also has to say something, that is looked at besides.
- *Stop* is the simulated time from when the robot had to stop until a command of zero arrived (or,
  as the row says, braking began). Where nothing arrives, that is when the time limit on
  silence is over, counted from the last good message; else when the first bad message went out. A
  period of 50 ms and 50 ms more are allowed. *Stands* is when the robot truly stood, which its
  brakes decide.
- It has to stay at zero until the fault ends, to stand, and to touch nothing.
- *Drives again* is the simulated time from the end of the fault until it drove straight again, at
  over half its speed; for a node that was ended, from when it was started again, starting included.
- *Lost*: poses that scans got no answer for; cells of the map that were known before; goals that
  had to be sent again, as a person at a screen would.

Time is simulated and waits for the planner's commands, so that a slow machine only takes longer. A
fault is run anew, and the row says so, where the machine stood still for 2 s, which stops the robot
too; and where it is not passed although nothing was touched, and time had gone on for want of a
command: it waits for one no longer than a second. Four times at most.

"""
_FOOT = """
## What to know beside the table

- `image-upside-down` is not noticed by any node: to `floor_detector` it is a room turned round.
  The row only says that nothing was touched while it lasted.
- With two sources of map to odom the robot stands as long as both are there: which of them is right
  nobody knows. One source that corrects itself, once, does not stop it.
- A second publisher on `cmd_vel` is named on `/diagnostics`, and the robot obeys both: end it, or
  put a multiplexer before the base.
- `local_planner` that is killed sends no zero. That the robot then stands is the base's own limit
  on silence; without one in the driver nothing stops it.
- `grid_mapper` keeps its map in memory. One that is killed is started again with `start_map` on
  what `~/save_map` wrote last, and is told on `initialpose` where the robot is: by itself it looks
  again only once the robot has moved.
- Ten times real time is what is asked for; the row says what was reached, as time waits for the
  planner. A tenth is kept to.
- Parameters of a wrong type are refused by rclpy, whose text does not name them.
- `lossy-network` needs network namespaces (Linux, root); where they may not be made it is left out
  and the run says so. `lossy-relay` does the same to messages anywhere.

`DIR/report.html` has the same with a plot of each drive; `DIR/traces/*.csv` the commands and the
motion behind it; `DIR/<graph>/logs/` what each process said.
"""
_COLUMNS = ("fault", "what", "expected", "seen", "stop ms", "stands s", "drives again s", "lost")


def faults_page(rows: list[Row], sim_s: float, machine: str) -> str:
    """Return the page."""
    passed = sum(row.passed for row in rows)
    said = f"**{passed} of {len(rows)} passed**, in {sim_s:.0f} simulated seconds ({machine}).\n"
    parts = [_HEAD, said]
    for graph in dict.fromkeys(row.graph for row in rows):
        parts += [f"\n## {graph}\n\n", _line(_COLUMNS), _line(["---"] * len(_COLUMNS))]
        parts += [_line(_cells(row)) for row in rows if row.graph == graph]
    return "".join([*parts, _FOOT])


def _cells(row: Row) -> list[str]:
    name = f"`{row.name}`" if row.passed else f"**not passed:** `{row.name}`"
    figures = [
        "" if row.stop_ms is None else f"{row.stop_ms:.0f}",
        "" if row.stand_s is None else f"{row.stand_s:.2f}",
        "never" if row.recover_s is None else f"{row.recover_s:.1f}",
    ]
    return [name, row.what, row.expected, row.seen, *figures, row.lost]


def _line(cells: list[str] | tuple[str, ...]) -> str:
    plain = (" ".join(cell.replace("|", "/").split()) for cell in cells)
    return f"| {' | '.join(plain)} |\n"
