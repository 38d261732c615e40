"""The six packages as ROS, pip and a robot see them: manifests, entry points, import rules."""

from __future__ import annotations

import ast
import configparser
import importlib.util
import re
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "ros_ws" / "src"
PACKAGES = (
    "floor_perception",
    "floornav_common",
    "grid_mapper",
    "multi_localizer",
    "sim_bridge",
    "sjmc_planner",
)
VERSION = "0.1.0"
SCRATCH = {"__pycache__", "build", "install", "log", ".mypy_cache"}
# Import name -> rosdep key that noble resolves.
ROSDEP_KEYS = {
    "cv2": "python3-opencv",
    "matplotlib": "python3-matplotlib",
    "numpy": "python3-numpy",
    "scipy": "python3-scipy",
    "yaml": "python3-yaml",
}
# What rosdep does not know; import name -> name in requirements-robot.txt.
FROM_PIP = {
    "apsw": "apsw",
    "backports": "backports-zstd",
    "kiss_icp": "kiss-icp",
    "lz4": "lz4",
    "numba": "numba",
    "rich": "rich",
    "rosbags": "rosbags",
    "threadpoolctl": "threadpoolctl",
    "websockets": "websockets",
}
# Not on a robot by default; the code says in one line what is missing.
OPTIONAL = {"compression", "nav2_msgs", "pybullet"}
ROS_KEYS = {
    "ament_index_python",
    "builtin_interfaces",
    "rcl_interfaces",
    "rclpy",
    "rosidl_runtime_py",
    "std_srvs",
}


def manifest(package: str) -> ET.Element:
    """Return package.xml of a package, parsed."""
    return ET.parse(SOURCES / package / "package.xml").getroot()


def modules(package: str) -> Iterator[Path]:
    """Yield the Python files of a package."""
    yield from sorted((SOURCES / package / package).rglob("*.py"))


def imports(package: str) -> dict[str, Path]:
    """Return what a package imports from outside the standard library, and one file that does."""
    found: dict[str, Path] = {}
    for path in modules(package):
        for node in ast.walk(ast.parse(path.read_text())):
            names: list[str] = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names = [node.module]
            for name in names:
                found.setdefault(name.partition(".")[0], path)
    return {n: p for n, p in found.items() if n not in sys.stdlib_module_names and n != package}


def setup_cfg(package: str) -> configparser.ConfigParser:
    """Return setup.cfg of a package, parsed."""
    config = configparser.ConfigParser(interpolation=None)
    config.read(SOURCES / package / "setup.cfg")
    return config


def executables(package: str) -> dict[str, str]:
    """Return the console scripts of a package: name -> "module:function"."""
    text = setup_cfg(package).get("options.entry_points", "console_scripts", fallback="")
    return {a.strip(): b.strip() for a, b in (x.split("=") for x in text.splitlines() if "=" in x)}


def test_the_six_packages_are_there() -> None:
    assert tuple(sorted(p.parent.name for p in SOURCES.glob("*/package.xml"))) == PACKAGES


@pytest.mark.parametrize("package", PACKAGES)
def test_manifest_is_valid(package: str) -> None:
    root = manifest(package)
    assert root.get("format") == "3"
    assert root.findtext("name") == package
    assert root.findtext("version") == VERSION
    assert root.findtext("license") == "Apache-2.0"
    assert root.findtext("export/build_type") == "ament_python"
    assert root.find("maintainer") is not None


@pytest.mark.parametrize("package", PACKAGES)
def test_manifest_is_accepted_by_ros_tools(package: str) -> None:
    catkin = pytest.importorskip("catkin_pkg.package")
    warnings: list[str] = []
    parsed = catkin.parse_package(str(SOURCES / package / "package.xml"), warnings=warnings)
    parsed.validate(warnings=warnings)
    assert warnings == []


@pytest.mark.parametrize("package", PACKAGES)
def test_setup_says_the_same_as_the_manifest(package: str) -> None:
    metadata = setup_cfg(package)["metadata"]
    assert metadata["name"] == package
    for key in ("version", "description", "license"):
        assert metadata[key] == manifest(package).findtext(key)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_data_file_is_installed(package: str) -> None:
    """Folders beside the package go to share/<package>, files inside it go along with it."""
    config, folder = setup_cfg(package), SOURCES / package
    files = [p for p in folder.rglob("[!.]*") if p.is_file() and not SCRATCH & set(p.parts)]
    inside = config.get("options.package_data", package, fallback="").split(",")
    shared = config["options.data_files"].items()
    for path in (p.relative_to(folder) for p in files if p.suffix not in (".py", ".pyc")):
        if path.parts[0] == package:
            assert any(path.relative_to(package).match(p.strip()) for p in inside), path
        elif len(path.parts) > 1:
            targets = [target for target, pattern in shared if path.match(pattern)]
            assert targets == [str(Path("share", package, path.parent))] or "resource" in path.parts


@pytest.mark.parametrize("package", PACKAGES)
def test_executables_go_where_ros2_run_looks(package: str) -> None:
    config = setup_cfg(package)
    assert config["develop"]["script_dir"] == f"$base/lib/{package}"
    assert config["install"]["install_scripts"] == f"$base/lib/{package}"
    assert config["build_scripts"]["executable"] == "/usr/bin/env python3"
    assert (SOURCES / package / "resource" / package).exists()


@pytest.mark.parametrize("package", PACKAGES)
def test_every_executable_is_a_function_that_exists(package: str) -> None:
    for name, target in executables(package).items():
        module, function = target.split(":")
        path = SOURCES / package / Path(*module.split(".")).with_suffix(".py")
        assert path.exists(), f"{name}: {path} is missing"
        defined = [
            n.name for n in ast.parse(path.read_text()).body if isinstance(n, ast.FunctionDef)
        ]
        assert function in defined, f"{name}: no {function}() in {path}"


@pytest.mark.parametrize("package", PACKAGES)
def test_every_executable_can_be_imported(package: str) -> None:
    pytest.importorskip("rclpy")
    for target in executables(package).values():
        module, function = target.split(":")
        assert callable(getattr(importlib.import_module(module), function))


@pytest.mark.parametrize("package", PACKAGES)
def test_manifest_names_what_is_imported_and_nothing_else(package: str) -> None:
    wanted = set()
    for name, path in imports(package).items():
        if name in ROSDEP_KEYS:
            wanted.add(ROSDEP_KEYS[name])
        elif name in ROS_KEYS | set(PACKAGES) or (name.endswith("_msgs") and name not in OPTIONAL):
            wanted.add(name)
        else:
            known = name in FROM_PIP or name in OPTIONAL
            assert known, f"{path} imports {name}: say in this test where a robot gets it from"
    root = manifest(package)
    named = {e.text for tag in ("depend", "exec_depend") for e in root.findall(tag)}
    assert named == wanted


@pytest.mark.parametrize("package", PACKAGES)
def test_robot_requirements_hold_what_rosdep_does_not_know(package: str) -> None:
    lock = (ROOT / "requirements-robot.txt").read_text()
    pinned = set(re.findall(r"^([a-z0-9-]+)==", lock, flags=re.MULTILINE))
    for name in set(imports(package)) & set(FROM_PIP):
        assert FROM_PIP[name] in pinned


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_import_only_the_common_one_of_ours(package: str) -> None:
    others = set(PACKAGES) - {package, "floornav_common"}
    assert {n: str(p) for n, p in imports(package).items() if n in others} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_with_python_is_a_package(package: str) -> None:
    for path in modules(package):
        assert (path.parent / "__init__.py").exists(), f"{path.parent} would not be installed"


def config_files() -> list[Path]:
    return sorted(SOURCES.glob("*/config/*.yaml"))


@pytest.mark.parametrize("path", config_files(), ids=lambda p: p.name)
def test_every_parameter_file_loads_into_its_dataclass(path: Path) -> None:
    """`config/<node>.yaml` belongs to the one configuration class whose field names it uses."""
    from floornav_common.config_files import load_config

    package = path.parent.parent.name
    module = importlib.import_module(f"{package}.config")
    wanted = path.stem.replace("_", "").lower() + "config"
    (config_class,) = [c for n, c in vars(module).items() if n.lower() == wanted]
    load_config(path, config_class, node=path.stem)


@pytest.mark.parametrize("name", ["pip-home.txt", "pip-cmake.txt", "colcon.txt", "noble.txt"])
def test_locks_are_hashed_and_name_no_host(name: str) -> None:
    check_lock(ROOT / "requirements" / name)


def test_robot_lock_is_hashed_and_keeps_nobles_numpy() -> None:
    path = ROOT / "requirements-robot.txt"
    check_lock(path)
    assert re.search(r"^numpy==1\.", path.read_text(), flags=re.MULTILINE)


def check_lock(path: Path) -> None:
    """Fail unless each requirement is pinned and hashed, without addresses and options."""
    text = path.read_text()
    assert "://" not in text
    assert not re.search(r"^-", text, flags=re.MULTILINE)
    for entry in text.replace("\\\n", " ").splitlines():
        assert re.match(r"[A-Za-z0-9._-]+==\S+.* --hash=sha256:[0-9a-f]{64}", entry), entry


def test_pybullet_is_locked_for_3_11_only() -> None:
    text = (ROOT / "requirements" / "pip-home.txt").read_text()
    assert re.search(r"^pybullet==\S+ ; python_full_version < '3\.12'", text, flags=re.MULTILINE)
