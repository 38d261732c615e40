"""Packages of the checkout in the environment, and what run_node says of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import _environment
import _package_links as links

SCRIPTS = Path(_environment.__file__).parent


def test_linked_packages_are_found_as_ros2_run_looks_for_them(tmp_path: Path) -> None:
    site_packages = tmp_path / "lib/python3.11/site-packages"
    site_packages.mkdir(parents=True)
    links.link_packages(tmp_path)
    links.link_packages(tmp_path)  # again changes nothing
    for package in links.find_packages().values():
        assert (tmp_path / "share/ament_index/resource_index/packages" / package.name).exists()
        assert (
            tmp_path / "share" / package.name / "package.xml"
        ).resolve().parent == package.folder
        programs = {
            p.name for p in (tmp_path / "lib" / package.name).iterdir() if os.access(p, os.X_OK)
        }
        assert programs == set(package.executables)
    assert str(links.SOURCES / "grid_mapper") in (site_packages / "floornav.pth").read_text()


# run_node


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["nope", "x"],
            'run_node: no package "nope"; there are: floor_perception, floornav_common,',
        ),
        (
            ["grid_mapper", "x"],
            'run_node: package grid_mapper has no executable "x"; it has: grid_mapper',
        ),
        (
            ["multi_localizer", "x"],
            'package multi_localizer has no executable "x"; it has: floor_localizer,',
        ),
        (["grid_mapper"], "run_node: PACKAGE and EXECUTABLE are needed"),
    ],
)
def test_run_node_says_what_there_is_on_a_wrong_name(words: list[str], said: str) -> None:
    answer = subprocess.run(
        [sys.executable, str(SCRIPTS / "run_node.py"), *words], capture_output=True, text=True
    )
    assert answer.returncode == 2
    assert said in answer.stderr
    assert answer.stderr.count("\n") == 1
    assert answer.stdout == ""
