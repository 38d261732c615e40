"""Files that parameters name: by path, or by the name of one that a package brings along."""

from __future__ import annotations

from importlib import resources
from pathlib import Path


def find_file(name_or_path: str, package: str, folder: str) -> Path:
    """Return the path of a YAML file.

    Args:
        name_or_path: A path that ends in `.yaml` or `.yml`, or a name in the package's folder.
        package: The package.
        folder: Its folder.

    Raises:
        ValueError: There is no such name.
    """
    if name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    place = resources.files(package) / folder
    known = sorted(f.name[: -len(".yaml")] for f in place.iterdir() if f.name.endswith(".yaml"))
    if name_or_path not in known:
        raise ValueError(
            f"no file named {name_or_path!r} in {folder}: a path ending in .yaml or one of "
            f"{', '.join(known)}"
        )
    return Path(str(place / f"{name_or_path}.yaml"))
