"""Compiled kernels are forgotten when the sources they came from change."""

import pytest

from _kernel_cache import forget_changed_kernels


@pytest.fixture
def sources(tmp_path):
    """Two packages with a kernel each, and what numba made of them."""
    for package in ("alpha", "beta"):
        folder = tmp_path / "src" / "ros_ws" / "src" / package
        (folder / package).mkdir(parents=True)
        (folder / "package.xml").touch()
        (folder / package / "kernels.py").write_text("from numba import njit\n")
        (folder / package / "plain.py").write_text("pass\n")
    return tmp_path / "src"


def compiled(cache, name):
    path = cache / f"{name}_0123" / "kernels.f-1.nbi"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return path


def test_only_the_package_that_changed_is_forgotten_and_what_builds_on_it(tmp_path, sources):
    cache = tmp_path / "cache"
    forget_changed_kernels(cache, sources)
    paths = {name: compiled(cache, name) for name in ("alpha", "beta", "experiments")}
    (sources / "ros_ws/src/alpha/alpha/kernels.py").write_text("from numba import njit  # new\n")
    forget_changed_kernels(cache, sources)
    assert {name for name, path in paths.items() if path.exists()} == {"beta"}


@pytest.mark.parametrize("name", ["alpha/alpha/plain.py", None])
def test_other_changes_keep_all(tmp_path, sources, name):
    cache = tmp_path / "cache"
    forget_changed_kernels(cache, sources)
    path = compiled(cache, "alpha")
    if name is not None:
        (sources / "ros_ws/src" / name).write_text("changed = True\n")
    forget_changed_kernels(cache, sources)
    assert path.exists()


def test_a_cache_of_unknown_sources_is_forgotten(tmp_path, sources):
    path = compiled(tmp_path / "cache", "beta")
    (tmp_path / "cache" / "sources.json").write_text("{cut")
    forget_changed_kernels(tmp_path / "cache", sources)
    assert not path.exists()
