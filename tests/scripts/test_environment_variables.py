"""What a process is given when it enters the environment."""

from __future__ import annotations

import os
from pathlib import Path

import _environment

BARE = {"PATH": os.environ["PATH"], "HOME": "/nonexistent"}


def test_user_settings_stay() -> None:
    environ = {"HOME": "/root", "OMP_NUM_THREADS": "4", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    environ |= {"NUMBA_CACHE_DIR": "/n", "FASTRTPS_DEFAULT_PROFILES_FILE": "/p.xml"}
    result = _environment.environment_of(Path("/env"), False, environ)
    assert {name: result[name] for name in environ} == environ


def test_discovery_stays_on_this_host_unless_the_user_chose() -> None:
    result = _environment.environment_of(Path("/env"), False, BARE)
    assert result["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    peers = _environment.environment_of(
        Path("/env"), False, {**BARE, "ROS_STATIC_PEERS": "10.0.0.2"}
    )
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE" not in peers


def test_profile_for_large_messages_is_set_and_exists() -> None:
    result = _environment.environment_of(Path("/env"), False, BARE)
    profile = Path(result["FASTRTPS_DEFAULT_PROFILES_FILE"])
    text = profile.read_text()
    assert "<segment_size>33554432</segment_size>" in text
    assert "<maxMessageSize>2097152</maxMessageSize>" in text
    assert "<useBuiltinTransports>false</useBuiltinTransports>" in text


def test_empty_home_gets_log_and_cache_folders_elsewhere() -> None:
    result = _environment.environment_of(Path("/env"), False, BARE)
    assert result["ROS_LOG_DIR"] == "/env/cache/ros_log"
    assert result["NUMBA_CACHE_DIR"] == "/env/cache/numba"
    assert result["MPLCONFIGDIR"] == "/env/cache/matplotlib"


def test_pip_home_forgets_an_installed_ros() -> None:
    environ = {
        **BARE,
        "ROS_DISTRO": "jazzy",
        "AMENT_PREFIX_PATH": "/ws/install/pkg:/opt/ros/jazzy",
        "PYTHONPATH": "/opt/ros/jazzy/lib/python3.12/site-packages:/mine",
        "LD_LIBRARY_PATH": "/opt/ros/jazzy/lib:/ws/install/pkg/lib:/usr/mine",
        "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
    }
    result = _environment.environment_of(Path("/env"), False, environ)
    assert result["AMENT_PREFIX_PATH"] == "/env"
    assert result["PYTHONPATH"] == "/mine"
    assert result["LD_LIBRARY_PATH"] == "/usr/mine"
    assert result["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"
    assert "ROS_DISTRO" not in result


def test_system_home_keeps_the_installed_ros() -> None:
    environ = {**BARE, "ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": "/opt/ros/jazzy"}
    environ |= {"PYTHONPATH": "/opt/ros/jazzy/lib/python3.12/site-packages"}
    result = _environment.environment_of(Path("/env"), True, environ)
    assert result["AMENT_PREFIX_PATH"] == "/env:/opt/ros/jazzy"
    assert result["PYTHONPATH"] == environ["PYTHONPATH"]


def test_child_of_another_environment_loses_the_wheels_flag_and_libraries(tmp_path: Path) -> None:
    (tmp_path / "pyvenv.cfg").write_text("")
    own = f"{tmp_path}/lib:{tmp_path}/lib/python3.11/site-packages/ros_rcl.libs"
    environ = {_environment.WHEELS_FLAG: "1", "LD_LIBRARY_PATH": f"{own}:/usr/mine", "A": "b"}
    environ["FLOORNAV_ENV_READY"] = "1"
    assert _environment.clean_child_environment(environ) == {
        "LD_LIBRARY_PATH": "/usr/mine",
        "A": "b",
    }
    environ["LD_LIBRARY_PATH"] = own
    assert _environment.clean_child_environment(environ) == {"A": "b"}


def test_libraries_of_the_user_stay_where_no_wheels_ran() -> None:
    environ = {"LD_LIBRARY_PATH": "/opt/a/lib:/opt/b/ros_x.libs"}
    assert _environment.clean_child_environment(environ) == environ
