#!/usr/bin/env python3
"""Run one node, with the arguments of `ros2 run`, in the project's environment.

    python3 scripts/run_node.py PACKAGE EXECUTABLE [--ros-args ...]
    python3 scripts/run_node.py --list

Exit code and signals are the node's own; a wrong name exits with 2.
"""

import sys
from importlib import import_module

from _environment import ensure_environment
from _package_links import find_packages, module_and_function


def main() -> int:
    """Find the executable, enter the environment, run."""
    words = sys.argv[1:]
    packages = find_packages()
    if words in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0
    if words == ["--list"]:
        print("\n".join(f"{p.name} {name}" for p in packages.values() for name in p.executables))
        return 0
    if len(words) < 2:
        print("run_node: PACKAGE and EXECUTABLE are needed (--list shows them)", file=sys.stderr)
        return 2
    try:
        module, function = module_and_function(packages, *words[:2])
    except LookupError as error:
        print(f"run_node: {error.args[0]}", file=sys.stderr)
        return 2
    ensure_environment(needs="node")
    sys.argv = [words[1], *words[2:]]
    return getattr(import_module(module), function)()


if __name__ == "__main__":
    sys.exit(main())
