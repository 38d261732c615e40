"""The environment that every script starts in: known answers, and nothing that downloads."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import _environment
import _environment_build as build
import _package_links as links
import _python_choice as choice
import _tf2_msgs as tf2
from _environment_stamp import STAMP, read_stamp, write_stamp

SCRIPTS = Path(_environment.__file__).parent
BARE = {"PATH": os.environ["PATH"], "HOME": "/nonexistent"}


def fake_python(
    folder: Path, name: str, version: str = "3.11.9", venv: int = 1, headers: int = 1
) -> str:
    """Write a program that answers the probe like a python of that version."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    major, minor, _ = version.split(".")
    answer = f"{major} {minor} {version} CPython\\n{path}\\n{venv}\\n{headers}\\n"
    path.write_text(f"#!/bin/sh\nprintf '{answer}'\n")
    path.chmod(0o755)
    return str(path)


@pytest.fixture
def only_fakes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the search see PATH only."""
    monkeypatch.setattr(
        choice,
        "_places",
        lambda environ: [
            os.path.join(folder, name)
            for name in ("python3.11", "python3.12", "python3")
            for folder in environ["PATH"].split(os.pathsep)
        ],
    )


# Choosing a python


def test_3_11_is_taken_before_3_12(tmp_path: Path, only_fakes: None) -> None:
    fake_python(tmp_path, "python3.12", "3.12.4")
    wanted = fake_python(tmp_path, "python3.11")
    assert choice.choose_python({"PATH": str(tmp_path)}).path == wanted


def test_a_shim_that_fails_is_passed_over(tmp_path: Path, only_fakes: None) -> None:
    shim = tmp_path / "shims" / "python3.11"
    shim.parent.mkdir()
    shim.write_text("#!/bin/sh\necho 'command not found' >&2\nexit 127\n")
    shim.chmod(0o755)
    wanted = fake_python(tmp_path / "real", "python3.12", "3.12.1")
    environ = {"PATH": f"{shim.parent}{os.pathsep}{tmp_path / 'real'}"}
    assert choice.choose_python(environ).path == wanted


def test_pyenvs_pythons_are_found_by_its_shims_on_path(tmp_path: Path) -> None:
    shims = tmp_path / "pyenv" / "shims"
    fake_python(shims, "python3.11")
    wanted = fake_python(tmp_path / "pyenv" / "versions" / "3.12.1" / "bin", "python", "3.12.1")
    environ = {"PATH": str(shims), "HOME": str(tmp_path)}
    assert wanted in choice.candidates(environ)


def test_a_python_with_headers_is_preferred(tmp_path: Path, only_fakes: None) -> None:
    fake_python(tmp_path / "a", "python3.11", headers=0)
    wanted = fake_python(tmp_path / "b", "python3.11", headers=1)
    environ = {"PATH": f"{tmp_path / 'a'}{os.pathsep}{tmp_path / 'b'}"}
    assert choice.choose_python(environ).path == wanted


def test_no_supported_python_is_one_line_that_names_what_is_there(
    tmp_path: Path, only_fakes: None
) -> None:
    fake_python(tmp_path, "python3", "3.9.2")
    with pytest.raises(LookupError) as error:
        choice.choose_python({"PATH": str(tmp_path)})
    assert error.value.args[0] == (
        "Python 3.11 or 3.12 is needed (found: 3.9.2); install one or name it in FLOORNAV_PYTHON"
    )


def test_a_python_without_venv_names_the_package_to_install(
    tmp_path: Path, only_fakes: None
) -> None:
    path = fake_python(tmp_path, "python3.11", venv=0)
    with pytest.raises(LookupError) as error:
        choice.choose_python({"PATH": str(tmp_path)})
    assert (
        error.value.args[0] == f"{path} cannot make virtual environments: install python3.11-venv"
    )


def test_the_users_choice_of_python_decides(tmp_path: Path, only_fakes: None) -> None:
    fake_python(tmp_path, "python3.11")
    wanted = fake_python(tmp_path / "mine", "python3.12", "3.12.1")
    environ = {"PATH": str(tmp_path), "FLOORNAV_PYTHON": wanted}
    assert choice.choose_python(environ).version == (3, 12)


@pytest.mark.parametrize(
    ("version", "said"),
    [("3.13.0", "is 3.13.0, not 3.11 or 3.12"), (None, "does not run")],
)
def test_a_users_choice_that_cannot_be_is_said(
    tmp_path: Path, version: str | None, said: str
) -> None:
    path = fake_python(tmp_path, "python", version) if version else str(tmp_path / "none")
    with pytest.raises(LookupError, match=said):
        choice.choose_python({"PATH": "", "FLOORNAV_PYTHON": path})


def test_our_own_python_is_found_by_running_it() -> None:
    found = choice.probe(sys.executable)
    assert found is not None
    assert found.version == sys.version_info[:2]


# Entering it


def entering(tmp_path: Path, body: str, needs: str = "offline") -> list[str]:
    """Return the command of a script that enters a stand-in environment and runs `body` there."""
    home = tmp_path / "home"
    (home / "bin").mkdir(parents=True)
    (home / "bin" / "python").symlink_to(sys.executable)
    script = tmp_path / "script.py"
    script.write_text(
        f"import sys; sys.path.insert(0, {str(SCRIPTS)!r})\n"
        "import _environment, _environment_build as b\nfrom pathlib import Path\n"
        f"b.ready_home = lambda is_system: b.Home(Path({str(home)!r}), is_system)\n"
        f"_environment.ensure_environment(needs={needs!r})\n{body}\n"
    )
    return [sys.executable, str(script)]


def outside() -> dict[str, str]:
    """Return the environment of a user's shell."""
    environ = _environment.clean_child_environment()
    return {k: v for k, v in environ.items() if not k.startswith(("AMENT", "ROS_", "FLOORNAV"))}


def test_arguments_and_exit_code_pass_through(tmp_path: Path) -> None:
    body = "import os\nprint(sys.argv[1:], os.environ['FLOORNAV_ENV_READY'])\nsys.exit(7)"
    answer = subprocess.run(
        [*entering(tmp_path, body), "a b", "--c"], env=outside(), capture_output=True, text=True
    )
    assert answer.stdout.strip() == "['a b', '--c'] 1"
    assert answer.returncode == 7


def test_signals_reach_the_command_itself(tmp_path: Path) -> None:
    body = (
        "import signal, time\nsignal.signal(signal.SIGTERM, lambda *_: sys.exit(5))\n"
        "print('on', flush=True)\ntime.sleep(600)"
    )
    process = subprocess.Popen(
        entering(tmp_path, body), env=outside(), stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "on\n"
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=60) == 5
    process.stdout.close()


def fake_jazzy(folder: Path) -> Path:
    """Write what tells an installed Jazzy: a set-up script, and the marker of its rclpy."""
    marker = folder / "share/ament_index/resource_index/packages/rclpy"
    marker.parent.mkdir(parents=True)
    marker.write_text("")
    setup = f"export ROS_DISTRO=jazzy AMENT_PREFIX_PATH={folder} PYTHONPATH={folder}/python\n"
    (folder / "setup.sh").write_text(setup)
    return folder


@pytest.mark.parametrize("is_sourced", [False, True])
@pytest.mark.parametrize(("needs", "is_used"), [("node", True), ("offline", False)])
def test_installed_jazzy_is_for_nodes_only(
    tmp_path: Path, needs: str, is_used: bool, is_sourced: bool
) -> None:
    jazzy = fake_jazzy(tmp_path / "jazzy")
    body = "import os\nprint(os.environ['AMENT_PREFIX_PATH'], os.environ.get('PYTHONPATH'))"
    command = entering(tmp_path, body, needs)
    script = Path(command[1])
    known = f"_environment.SYSTEM_ROS_PREFIX = Path({str(jazzy)!r})\n_environment.ensure_env"
    script.write_text(script.read_text().replace("_environment.ensure_env", known, 1))
    shell = outside()
    if is_sourced:
        shell |= {"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": str(jazzy)}
        shell |= {"PYTHONPATH": f"{jazzy}/python"}
    answer = subprocess.run(command, env=shell, capture_output=True, text=True)
    home = tmp_path / "home"
    wanted = f"{home}:{jazzy} {jazzy}/python" if is_used else f"{home} None"
    assert answer.stdout.strip() == wanted, answer.stderr


def test_inside_the_environment_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLOORNAV_ENV_READY", "1")
    monkeypatch.setattr(build, "ready_home", lambda is_system: pytest.fail("made an environment"))
    _environment.ensure_environment()


def test_a_need_nobody_knows_is_refused() -> None:
    with pytest.raises(ValueError, match="needs must be"):
        _environment.ensure_environment(needs="everything")


def test_failed_set_up_is_one_line_and_exit_1(tmp_path: Path) -> None:
    environ = {**outside(), "FLOORNAV_PYTHON": "/nonexistent", "FLOORNAV_VENV": str(tmp_path / "v")}
    answer = subprocess.run(
        [sys.executable, str(SCRIPTS / "test.py"), "--version"],
        env=environ, capture_output=True, text=True,
    )  # fmt: skip
    assert answer.returncode == 1
    assert answer.stderr == "floornav: error: FLOORNAV_PYTHON=/nonexistent does not run\n"


# Up to date or not


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> build.Home:
    """Return a stand-in pip home that is up to date, made from a lock of its own."""
    monkeypatch.delenv("FLOORNAV_PYTHON", raising=False)
    lock = tmp_path / "lock.txt"
    lock.write_text("numpy==1 --hash=sha256:0\n")
    monkeypatch.setattr(build, "PIP_LOCK", lock)
    result = build.Home(tmp_path / "venv", False)
    (result.prefix / "bin").mkdir(parents=True)
    (result.prefix / "bin" / "python").symlink_to(sys.executable)
    stamp = {"libraries": build.libraries_key(result), "tf2_msgs": build.tf2_key(result, {})}
    write_stamp(result.prefix, {**stamp, "packages": links.links_key(), "python": "3.11.9"})
    return result


def test_finished_environment_is_taken_as_it_is(home: build.Home) -> None:
    assert build.is_current(home)


def test_changed_lock_makes_it_stale(home: build.Home) -> None:
    build.PIP_LOCK.write_text("numpy==2 --hash=sha256:0\n")
    assert not build.is_current(home)


@pytest.mark.parametrize("layer", ["libraries", "tf2_msgs", "packages"])
def test_interrupted_set_up_is_not_taken_for_a_good_one(home: build.Home, layer: str) -> None:
    stamp = read_stamp(home.prefix)
    del stamp[layer]
    write_stamp(home.prefix, stamp)
    assert not build.is_current(home)


def test_half_a_stamp_counts_as_none(home: build.Home) -> None:
    path = home.prefix / STAMP
    path.write_text(path.read_text()[:20])
    assert not build.is_current(home)


def test_python_that_is_gone_makes_it_stale(home: build.Home) -> None:
    (home.prefix / "bin" / "python").unlink()
    (home.prefix / "bin" / "python").symlink_to("/nonexistent/python")
    assert not build.is_current(home)


def test_another_python_asked_for_makes_it_stale(
    home: build.Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FLOORNAV_PYTHON", fake_python(tmp_path, "p", "3.12.1"))
    assert not build.is_current(home)
    monkeypatch.setenv("FLOORNAV_PYTHON", fake_python(tmp_path, "q", "3.11.9"))
    assert build.is_current(home)


def test_tf2_msgs_is_tried_again_when_a_compiler_has_come(
    home: build.Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_stamp(home.prefix, {**read_stamp(home.prefix), "tf2_msgs": "missing"})
    monkeypatch.setattr(build, "check_compiler", lambda: None)
    assert not build.is_current(home)

    def none() -> None:
        raise tf2.BuildToolMissingError("no C compiler found")

    monkeypatch.setattr(build, "check_compiler", none)
    assert build.is_current(home)


def test_an_environment_taken_over_from_another_checkout_is_warned_of(
    home: build.Home,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.setattr(build, "home_prefix", lambda is_system: home.prefix)
    pth = home.prefix / "lib" / "python3.11" / "site-packages" / "floornav.pth"
    pth.parent.mkdir(parents=True)
    links.link_packages(home.prefix)
    ours = pth.read_text()
    theirs = tmp_path / "other" / "ros_ws" / "src" / "grid_mapper"
    pth.write_text(f"{theirs}\n")
    write_stamp(home.prefix, {**read_stamp(home.prefix), "packages": "theirs"})
    assert links.linked_checkout(home.prefix) is None  # it is not there any more
    theirs.mkdir(parents=True)
    build.ready_home()
    said = capsys.readouterr().err
    assert f"belonged to {tmp_path / 'other'}; " in said and str(build.ROOT) in said
    assert pth.read_text() == ours and links.linked_checkout(home.prefix) is None
    assert read_stamp(home.prefix)["checkout"] == str(build.ROOT)
    build.ready_home()
    assert capsys.readouterr().err == ""


# tf2_msgs


def test_missing_compiler_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(tf2.BuildToolMissingError) as error:
        tf2.check_compiler()
    assert error.value.args[0] == "no C compiler found (cc, gcc, clang)"


def test_without_compiler_the_rest_is_made_and_said_in_one_line(
    home: build.Home,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    stamp = read_stamp(home.prefix)
    del stamp["tf2_msgs"]
    write_stamp(home.prefix, stamp)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(build, "home_prefix", lambda is_system: home.prefix)
    assert build.ready_home() == home
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "tf2_msgs not built, no C compiler found" in said
    assert read_stamp(home.prefix)["tf2_msgs"] == "missing"
    assert build.is_current(home)


def test_paths_of_the_wheels_build_machine_become_this_machines() -> None:
    old = "/opt/python/cp311-cp311"
    text = f'"{old}/include/python3.11;{old}/lib/python3.11/site-packages/numpy/_core/include"'
    facts = {"include": "/inc", "numpy_include": "/np"}
    assert tf2.with_local_paths(text, facts) == '"/inc;/np"'


def test_type_hashes_are_those_of_an_installed_jazzy() -> None:
    """A subscriber of another type hash would not be matched; known from recordings of robots."""
    pytest.importorskip("tf2_msgs.msg")
    prefixes = os.environ["AMENT_PREFIX_PATH"].split(os.pathsep)
    files = [Path(p) / "share/tf2_msgs/msg/TFMessage.json" for p in prefixes]
    (path,) = [p for p in files if p.exists()]
    hashes = {t["type_name"]: t["hash_string"] for t in json.loads(path.read_text())["type_hashes"]}
    assert hashes["tf2_msgs/msg/TFMessage"] == (
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
    )
