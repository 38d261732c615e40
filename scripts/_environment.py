"""The project's environment: every script starts here, before it imports anything else.

    from _environment import ensure_environment

    ensure_environment()                 # offline commands: always the pip home
    ensure_environment(needs="node")     # commands over DDS: the system's Jazzy if there is one

There are two homes. The *pip home* is `.venv` in the checkout, made from wheels on first use (ROS
included). The *system home* is `.venv-ros`, which sees the packages of an installed ROS 2 Jazzy
and adds only what `rosdep` does not know; pip's rclpy never gets into it. Either is made again
when its lock changes. `ensure_environment` then replaces the running process by the same command
in that environment, so exit codes and signals are the command's own.

Variables of the user: FLOORNAV_PYTHON (interpreter to use), FLOORNAV_VENV (another folder for the
pip home), FLOORNAV_ENV_READY=1 (the right environment is active: return at once).

Standard library only, and syntax that Python 3.9 reads, so that an old python can say what is
missing.
"""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SYSTEM_ROS_PREFIX = Path("/opt/ros/jazzy")
DDS_PROFILE = ROOT / "ros_ws" / "src" / "floornav_common" / "config" / "fastdds_profile.xml"
READY = "FLOORNAV_ENV_READY"
WHEELS_FLAG = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
# One thread a process: several nodes share the cores, and results do not depend on their number.
THREAD_LIMITS = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
)
DISCOVERY_CHOICES = (
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
    "ROS_DISCOVERY_SERVER",
)


def ensure_environment(needs="offline"):
    """Go on in the project's environment, making it on first use.

    Returns only in a process that runs inside that environment.

    Args:
        needs: "offline" (pip home, also where ROS is installed) or "node" (the system's ROS 2 Jazzy
            where there is one, else the pip home).

    Raises:
        ValueError: If needs is neither.
    """
    if needs not in ("offline", "node"):
        raise ValueError(f'needs must be "offline" or "node", got {needs!r}')
    if os.environ.get(READY) == "1":
        return
    from _environment_build import SetupError, ready_home
    from _kernel_cache import forget_changed_kernels

    if (
        needs == "node"
        and not _is_system_ros_active()
        and (SYSTEM_ROS_PREFIX / "setup.sh").exists()
    ):
        _replace_process_with_ros_sourced()
    try:
        home = ready_home(is_system=needs == "node" and _is_system_ros_active())
    except SetupError as error:
        print(f"floornav: error: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        print("floornav: set-up interrupted; the next command starts it again", file=sys.stderr)
        sys.exit(130)
    environ = environment_of(home.prefix, home.is_system, os.environ)
    forget_changed_kernels(environ["NUMBA_CACHE_DIR"])
    sys.stdout.flush()
    sys.stderr.flush()
    python = str(home.prefix / "bin" / "python")
    os.execve(python, [python, *_own_arguments()], environ)


def environment_of(prefix, is_system, environ):
    """Return the variables for a process in the environment at `prefix`; the user's own stay."""
    result = clean_child_environment(environ)
    if not is_system:
        _drop_installed_ros(result)
        result["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"  # the only one among the wheels
    result.setdefault("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    result["AMENT_PREFIX_PATH"] = _joined(str(prefix), result.get("AMENT_PREFIX_PATH", ""))
    result["PYTHONNOUSERSITE"] = "1"
    result[READY] = "1"
    if not any(name in result for name in DISCOVERY_CHOICES):
        result["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    if "FASTDDS_DEFAULT_PROFILES_FILE" not in result:
        result.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(DDS_PROFILE))
    for name in THREAD_LIMITS:
        result.setdefault(name, "1")
    cache = Path(prefix) / "cache"
    result.setdefault("NUMBA_CACHE_DIR", str(cache / "numba"))
    result.setdefault("MPLCONFIGDIR", str(cache / "matplotlib"))
    home = result.get("HOME", "")
    if not (home and os.access(home, os.W_OK)) and "ROS_HOME" not in result:
        result.setdefault("ROS_LOG_DIR", str(cache / "ros_log"))
    return result


def clean_child_environment(environ=None):
    """Return a copy of `environ` (default: ours) for a child that runs in another environment.

    The ROS wheels restart python with their libraries in LD_LIBRARY_PATH and a flag that says so.
    A child of another environment would take the flag for its own and load our libraries.
    """
    result = dict(os.environ if environ is None else environ)
    result.pop(READY, None)
    if result.pop(WHEELS_FLAG, None) is not None:
        _keep_paths(result, "LD_LIBRARY_PATH", lambda path: not _is_wheel_path(path))
    return result


def _is_wheel_path(path):
    """Tell whether the wheels put `path` there: <prefix>/lib or .../ros_<name>.libs."""
    folder = Path(path)
    if folder.name.startswith("ros_") and folder.name.endswith(".libs"):
        return True
    return folder.name == "lib" and (folder.parent / "pyvenv.cfg").exists()


def _drop_installed_ros(environ):
    """Forget an installed ROS: its packages must not shadow the wheels."""
    prefixes = [str(SYSTEM_ROS_PREFIX.parent)]
    for name in ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH"):
        prefixes += [path for path in environ.pop(name, "").split(os.pathsep) if path]

    def is_foreign(path):
        return not any(path == prefix or path.startswith(prefix + os.sep) for prefix in prefixes)

    for name in ("PYTHONPATH", "LD_LIBRARY_PATH"):
        _keep_paths(environ, name, is_foreign)
    for name in ("PYTHONHOME", "ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION"):
        environ.pop(name, None)


def _keep_paths(environ, name, keep):
    """Keep the entries of a path list that `keep` accepts; drop the variable if none is left."""
    paths = [path for path in environ.pop(name, "").split(os.pathsep) if path and keep(path)]
    if paths:
        environ[name] = os.pathsep.join(paths)


def _joined(first, rest):
    """Put a path in front of a path list, once."""
    paths = [path for path in rest.split(os.pathsep) if path and path != first]
    return os.pathsep.join([first, *paths])


def _is_system_ros_active():
    """Tell whether an installed Jazzy is sourced: its rclpy is on the paths of this shell."""
    if os.environ.get("ROS_DISTRO") != "jazzy":
        return False
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    marker = Path("share", "ament_index", "resource_index", "packages", "rclpy")
    return any(prefix and (Path(prefix) / marker).exists() for prefix in prefixes)


def _replace_process_with_ros_sourced():
    """Start this command again with the installed Jazzy sourced; returns if that was done."""
    if os.environ.get("FLOORNAV_ROS_SOURCED") == "1":
        return
    environ = clean_child_environment()
    environ["FLOORNAV_ROS_SOURCED"] = "1"
    line = f'. "{SYSTEM_ROS_PREFIX}/setup.sh" && exec "$0" "$@"'
    os.execve("/bin/sh", ["sh", "-c", line, sys.executable, *_own_arguments()], environ)


def _own_arguments():
    """Return what followed the interpreter on the command line, its own options included."""
    return list(getattr(sys, "orig_argv", [sys.executable, *sys.argv])[1:])
