"""Installs the package where `ros2 run` finds it; its executables are listed in setup.cfg."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "floornav_common"
NOT_DATA = {PACKAGE, "resource", "test", "build", "install", "log"}

# Every other folder is data and goes to share/<package>/<folder>, subfolders included.
folders = [p for p in sorted(Path().iterdir()) if p.is_dir() and p.name not in NOT_DATA]
folders = [p for p in folders if p.suffix != ".egg-info" and not p.name.startswith(".")]
files = [f for p in folders for f in sorted(p.rglob("*")) if f.is_file()]
files = [f for f in files if "__pycache__" not in f.parts]
inside = [p for p in Path(PACKAGE).rglob("*") if p.is_file() and p.suffix not in {".py", ".pyc"}]

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: [str(p.relative_to(PACKAGE)) for p in inside]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *[(f"share/{PACKAGE}/{f.parent}", [str(f)]) for f in files],
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="floornav contributors",
    maintainer_email="floornav@users.noreply.github.com",
    description="Ground floor of floornav: poses, messages, parameters, frames, QoS, diagnostics.",
    license="Apache-2.0",
)
