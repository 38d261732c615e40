"""Make our packages visible in an environment, without copying them.

What `colcon build --symlink-install` leaves in an install space, made by links, so that a change in
the checkout takes effect at once: the import path, the entry points, `lib/<package>/<executable>`,
`share/<package>/` and the markers that `ros2 run` looks for.

Standard library only; syntax that Python 3.9 reads.
"""

import configparser
import hashlib
import re
import shutil
import sys
from pathlib import Path
from typing import NamedTuple

from _environment import ROOT

SOURCES = ROOT / "ros_ws" / "src"
NOT_DATA = ("resource", "test", "build", "install", "log")

EXECUTABLE = """#!{python}
import sys
from {module} import {function}

sys.exit({function}())
"""


class Package(NamedTuple):
    """One ROS package of the checkout."""

    name: str
    folder: Path
    version: str
    executables: dict  # name -> "module:function"


def find_packages(sources=SOURCES):
    """Return our packages by name, read from package.xml and setup.cfg."""
    packages = {}
    for manifest in sorted(Path(sources).glob("*/package.xml")):
        folder = manifest.parent
        version = re.search(r"<version>(.*?)</version>", manifest.read_text()).group(1)
        config = configparser.ConfigParser(interpolation=None)
        config.read(folder / "setup.cfg")
        lines = config.get("options.entry_points", "console_scripts", fallback="").splitlines()
        pairs = [line.split("=", 1) for line in lines if "=" in line]
        executables = {name.strip(): target.strip() for name, target in pairs}
        packages[folder.name] = Package(folder.name, folder, version, executables)
    return packages


def links_key():
    """Hash what decides the links: the place of the checkout, manifests, and the data folders."""
    result = hashlib.sha256(str(ROOT).encode())
    for package in find_packages().values():
        result.update(
            repr((package.name, package.version, sorted(package.executables.items()))).encode()
        )
        result.update(repr(_data_folders(package)).encode())
    result.update(Path(__file__).read_bytes())
    return result.hexdigest()


def link_packages(prefix):
    """Put links to all our packages into the environment at `prefix`, replacing older ones."""
    prefix = Path(prefix)
    (site_packages,) = prefix.glob("lib/python3.*/site-packages")
    packages = find_packages()
    (site_packages / "floornav.pth").write_text("".join(f"{p.folder}\n" for p in packages.values()))
    for package in packages.values():
        _write_metadata(package, site_packages)
        _link_share(package, prefix)
        _write_executables(package, prefix)


def linked_checkout(prefix):
    """Return the other checkout whose packages an environment has; None if it is this one's.

    A checkout that is not there any more has nothing to lose and does not count.
    """
    for path in Path(prefix).glob("lib/python3.*/site-packages/floornav.pth"):
        for line in path.read_text().splitlines():
            folder = Path(line)
            if SOURCES not in folder.parents and folder.is_dir():
                return folder.parents[2]
    return None


def _write_metadata(package, site_packages):
    """Write the metadata by which importlib.metadata finds version and entry points."""
    for old in site_packages.glob(f"{package.name}-*.dist-info"):
        shutil.rmtree(old)
    folder = site_packages / f"{package.name}-{package.version}.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {package.name}\nVersion: {package.version}\n"
    )
    (folder / "INSTALLER").write_text("floornav\n")
    scripts = "".join(f"{name} = {target}\n" for name, target in package.executables.items())
    (folder / "entry_points.txt").write_text(f"[console_scripts]\n{scripts}")


def _link_share(package, prefix):
    """Link share/<package> and the marker of the resource index."""
    share = prefix / "share" / package.name
    if share.exists():
        shutil.rmtree(share)
    share.mkdir(parents=True)
    for item in [
        package.folder / "package.xml",
        *(package.folder / name for name in _data_folders(package)),
    ]:
        (share / item.name).symlink_to(item)
    marker = prefix / "share" / "ament_index" / "resource_index" / "packages" / package.name
    marker.parent.mkdir(parents=True, exist_ok=True)
    marker.write_text("")


def _write_executables(package, prefix):
    """Write lib/<package>/<executable>, which `ros2 run` starts."""
    folder = prefix / "lib" / package.name
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    for name, target in package.executables.items():
        module, function = target.split(":")
        python = prefix / "bin" / "python"
        (folder / name).write_text(
            EXECUTABLE.format(python=python, module=module, function=function)
        )
        (folder / name).chmod(0o755)


def _data_folders(package):
    """Return the names of the folders that the package installs under share."""
    names = (p.name for p in sorted(package.folder.iterdir()) if p.is_dir())
    return [
        n
        for n in names
        if n != package.name and n not in NOT_DATA and not n.endswith(".egg-info") and n[0] != "."
    ]


def module_and_function(packages, package, executable):
    """Return ("module", "function") of an executable.

    Raises:
        LookupError: If there is none; the text is one line that lists what there is.
    """
    if package not in packages:
        raise LookupError(f'no package "{package}"; there are: {", ".join(packages)}')
    found = packages[package].executables
    if executable not in found:
        there = ", ".join(sorted(found)) or "none yet"
        raise LookupError(f'package {package} has no executable "{executable}"; it has: {there}')
    return tuple(found[executable].split(":"))


if __name__ == "__main__":
    link_packages(sys.prefix)
