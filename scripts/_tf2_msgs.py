"""Build tf2_msgs from its interface definitions into an environment made of ROS wheels.

No wheel carries tf2_msgs. The wheels do carry the generators, so the package in
`scripts/tf2_interfaces/` is built like any interface package, with two differences: the generators'
exported cmake files name Python and numpy folders of the machine that built the wheels, which are
replaced by this machine's, and the result is copied into the environment's own `lib`, `share` and
`site-packages`, where the wheels keep theirs, so that no path has to be set.

Standard library only; runs under any python >= 3.9.
"""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from _environment import clean_child_environment

SOURCE_DIR = Path(__file__).resolve().parent / "tf2_interfaces"
WHEEL_BUILDER_PYTHON = re.compile(r"/opt/python/cp\d+-cp\d+")

FOREIGN_SETTINGS = ("CMAKE_PREFIX_PATH", "COLCON_PREFIX_PATH", "PYTHONPATH", "ROS_DISTRO")
FOREIGN_SETTINGS += ("CFLAGS", "CXXFLAGS", "LDFLAGS")


class BuildToolMissingError(Exception):
    """The machine has no compiler, no build program or no headers of the interpreter."""


def build_tf2_msgs(prefix, cmake=None, log_path=None):
    """Build tf2_msgs and install it into the environment at `prefix`.

    Args:
        prefix: Environment (sys.prefix) that holds the ROS wheels and gets the package.
        cmake: The cmake to run; default the one in the environment or on PATH.
        log_path: File that gets the output of cmake and the compiler.

    Raises:
        BuildToolMissingError: If this machine cannot compile; the text is one line.
        RuntimeError: If the build failed; the text ends with the last lines of the log.
    """
    prefix = Path(prefix)
    facts = _interpreter_facts(prefix)
    cmake = cmake or find_cmake(prefix)
    check_compiler()
    if cmake is None:
        raise BuildToolMissingError("no cmake found")
    if not (Path(facts["include"]) / "Python.h").exists():
        raise BuildToolMissingError(
            f"no Python.h in {facts['include']} (install the python3-dev package)"
        )
    log_path = Path(log_path or prefix / "tf2_msgs_build.log")
    with tempfile.TemporaryDirectory(prefix="floornav_tf2_msgs_") as scratch:
        overlay = _overlay_with_local_paths(prefix, Path(scratch) / "overlay", facts)
        staged = Path(scratch) / "install"
        _run_cmake(cmake, prefix, overlay, Path(scratch) / "build", staged, facts, log_path)
        _name_prefix(staged, prefix)
        _copy_into(staged, prefix, Path(facts["site_packages"]))


def check_compiler():
    """Raise BuildToolMissingError with one clear line for the first program that is missing."""
    wanted = (
        ("C compiler", ("cc", "gcc", "clang")),
        ("C++ compiler", ("c++", "g++", "clang++")),
        ("make", ("make", "gmake")),
    )
    for what, names in wanted:
        if not any(shutil.which(name) for name in names):
            raise BuildToolMissingError(f"no {what} found ({', '.join(names)})")


def find_cmake(prefix):
    """Return the environment's cmake, else the one on PATH, else None."""
    own = Path(prefix) / "bin" / "cmake"
    return str(own) if own.exists() else shutil.which("cmake")


def _interpreter_facts(prefix):
    """Ask the environment's interpreter where its headers, numpy's headers and packages are."""
    ask = (
        "import sysconfig, numpy; p = sysconfig.get_paths();"
        "print(p['include'], numpy.get_include(), p['purelib'], sep='\\n')"
    )
    answer = subprocess.run(
        [str(prefix / "bin" / "python"), "-c", ask], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    return dict(zip(("include", "numpy_include", "site_packages"), answer))


def _overlay_with_local_paths(prefix, overlay, facts):
    """Copy the share folder's cmake files that name the wheel builder's Python, corrected.

    A package's cmake files find their libraries relative to themselves (three folders up), so the
    copy sits in a tree of links that looks like the environment. The environment is not touched.
    """
    overlay.mkdir(parents=True)
    for name in ("include", "lib", "lib64", "bin", "tools"):
        if (prefix / name).exists():
            (overlay / name).symlink_to(prefix / name)
    shutil.copytree(
        prefix / "share", overlay / "share", ignore=shutil.ignore_patterns("man", "doc")
    )
    for path in (overlay / "share").rglob("*.cmake"):
        text = path.read_text()
        if WHEEL_BUILDER_PYTHON.search(text):
            path.write_text(with_local_paths(text, facts))
    return overlay


def with_local_paths(text, facts):
    """Replace the wheel builder's numpy and Python include folders by this machine's."""
    builder = WHEEL_BUILDER_PYTHON.pattern
    text = re.sub(
        builder + r"/lib/python[\d.]+/site-packages/numpy/_?core/include",
        facts["numpy_include"],
        text,
    )
    return re.sub(builder + r"/include/python[\d.]+", facts["include"], text)


def _run_cmake(cmake, prefix, overlay, build, staged, facts, log_path):
    """Configure, build and install to `staged`; the output goes to `log_path`."""
    python = prefix / "bin" / "python"
    configure = [
        cmake, "-S", str(SOURCE_DIR), "-B", str(build),
        "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF",
        f"-DCMAKE_INSTALL_PREFIX={staged}", f"-DCMAKE_PREFIX_PATH={overlay}",
        f"-DPython3_EXECUTABLE={python}", f"-DPYTHON_EXECUTABLE={python}",
        f"-DPython3_INCLUDE_DIR={facts['include']}",
        f"-DPython3_NumPy_INCLUDE_DIR={facts['numpy_include']}",
        "-DPython3_FIND_STRATEGY=LOCATION", "-Wno-dev",
    ]  # fmt: skip
    environment = clean_child_environment()
    for name in FOREIGN_SETTINGS:
        environment.pop(name, None)
    environment["AMENT_PREFIX_PATH"] = str(overlay)
    environment["PATH"] = f"{prefix / 'bin'}{os.pathsep}{environment.get('PATH', os.defpath)}"
    steps = [
        configure,
        [cmake, "--build", str(build), "--parallel", "2"],
        [cmake, "--install", str(build)],
    ]
    with open(log_path, "w") as log:
        for step in steps:
            answer = subprocess.run(step, stdout=log, stderr=subprocess.STDOUT, env=environment)
            if answer.returncode != 0:
                tail = "\n".join(Path(log_path).read_text(errors="replace").splitlines()[-15:])
                raise RuntimeError(f"building tf2_msgs failed ({log_path}):\n{tail}")


def _name_prefix(staged, prefix):
    """Name the environment instead of the scratch folder in the set-up scripts."""
    for path in (staged / "share").rglob("*.*sh"):
        path.write_text(path.read_text().replace(str(staged), str(prefix)))


def _copy_into(staged, prefix, site_packages):
    """Copy the installed tree to where the wheels keep theirs, the Python package last.

    Files are replaced, not written over: a running process may have the old libraries loaded.
    """
    (package,) = (staged / "lib").glob("python*/site-packages/tf2_msgs")
    for name in ("share", "include"):
        _copy_tree(staged / name, prefix / name)
    for library in (staged / "lib").glob("lib*.so*"):
        _replace(library, prefix / "lib" / library.name)
    for metadata in package.parent.glob("tf2_msgs-*"):
        _copy_tree(metadata, site_packages / metadata.name)
    _copy_tree(package, site_packages / "tf2_msgs")


def _copy_tree(source, target):
    """Copy a folder over another, file by file; bytecode stays behind."""
    no_bytecode = shutil.ignore_patterns("__pycache__")
    shutil.copytree(source, target, copy_function=_replace, ignore=no_bytecode, dirs_exist_ok=True)


def _replace(source, target):
    """Put a copy of a file in place of another."""
    scratch = f"{target}.new"
    shutil.copy2(source, scratch)
    os.replace(scratch, target)
