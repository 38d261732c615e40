"""Run several nodes of ours in one process: `compose PACKAGE/EXECUTABLE ... [--ros-args ...]`.

Ten nodes in one process take 78 MB, in ten processes 670. Remap a single one of them by its name,
as upstream does: `--ros-args -r grid_mapper:scan:=front/scan`.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from floornav_common.start import leave_on_signal


def main(args: list[str] | None = None) -> int:
    """Parse the command line and run; returns the exit code."""
    if args is None:
        leave_on_signal()
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="compose",
        description="Run several nodes in one process.",
        epilog="Nodes that are installed: " + (", ".join(sorted(nodes_installed())) or "none"),
    )
    parser.add_argument("nodes", nargs="+", metavar="PACKAGE/EXECUTABLE")
    at = words.index("--ros-args") if "--ros-args" in words else len(words)
    names = parser.parse_args(words[:at]).nodes
    try:
        classes = [find_node_class(name) for name in names]
    except (ValueError, ImportError) as error:
        print(f"compose: {error}", file=sys.stderr)
        return 2
    from floornav_common.ros.main import run_nodes

    return run_nodes(classes, ["compose", *words[at:]])


def nodes_installed() -> dict[str, EntryPoint]:
    """Return the executables that are nodes, by `PACKAGE/EXECUTABLE`.

    Such is a console script whose function stands in the package's `nodes` folder; its node is in
    the module `<executable>_node` there.
    """
    scripts = entry_points(group="console_scripts")
    found = {}
    for script in scripts:
        package, _, rest = script.value.partition(".")
        if rest.startswith("nodes."):
            found[f"{package}/{script.name}"] = script
    return found


def find_node_class(name: str) -> Any:
    """Return the node class behind `PACKAGE/EXECUTABLE`.

    Raises:
        ValueError: If there is none; names what there is.
        ImportError: If something it needs is missing.
    """
    installed = nodes_installed()
    if name not in installed:
        there = ", ".join(sorted(installed)) or "none"
        raise ValueError(f"no node '{name}' is installed; there are: {there}")
    from floornav_common.ros.main import node_classes

    package, _, executable = name.partition("/")
    module = importlib.import_module(f"{package}.nodes.{executable}_node")
    classes = node_classes(module)
    if len(classes) != 1:
        raise ValueError(f"'{name}' must define one node class, it defines {len(classes)}")
    return classes[0]


if __name__ == "__main__":
    sys.exit(main())
