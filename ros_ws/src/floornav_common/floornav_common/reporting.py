"""What every floornav command shares: its options, result folder, summary, exit code, progress.

    def main(argv: list[str] | None = None) -> int:
        args = parser.parse_args(argv)
        out = open_out_dir("map_bag", bag.stem, args.out)
        with summary(out, command="map_bag", seed=args.seed, values={"scans": None}) as values:
            values["scans"] = ...
        return 0

    if __name__ == "__main__":
        sys.exit(run_command(main))

Exit codes: 0 done, 1 failed on the way (or stopped by Ctrl-C), 2 bad input or usage.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.metadata
import json
import os
import platform
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from floornav_common.arguments import natural
from floornav_common.progress import Progress, say
from floornav_common.report_page import (
    Block,
    Figures,
    Picture,
    Preformatted,
    Section,
    Table,
    render_page,
)

__all__ = [
    "Block", "Figures", "Picture", "Preformatted", "Progress", "Section", "Table", "UserError",
    "add_common_options", "open_out_dir", "run_command", "say", "summary", "write_atomic",
    "write_html", "write_summary",
]  # fmt: skip

_IMPORTED_AT = time.monotonic()
_PACKAGES = (
    "numpy", "scipy", "opencv-python-headless", "numba", "kiss-icp", "pybullet", "rosbags",
    "rclpy", "ros-jazzy-rclpy",
)  # fmt: skip
_SUMMARY_HEAD = (
    "command", "version", "seed", "machine", "python", "packages", "wall_s", "ok", "partial",
)  # fmt: skip


class UserError(Exception):
    """Bad input or usage: its text is one line for the user, and the command exits with 2."""


def add_common_options(parser: argparse.ArgumentParser, *, seed: int = 0) -> None:
    """Add `--out`, `--seed` and `--quiet`."""
    text = "folder for the results (default: out/<command>-<name>; -2, -3 ... if it exists)"
    parser.add_argument("--out", metavar="DIR", default=None, help=text)
    text = f"seed of every random number (default: {seed})"
    parser.add_argument("--seed", type=natural, metavar="N", default=seed, help=text)
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def open_out_dir(command: str, name: str, out: str | Path | None = None) -> Path:
    """Make a new result folder and return it; an existing one gets `-2`, `-3`, and that is said.

    Args:
        command: Name of the command, for the default `out/<command>-<name>`.
        name: Name of the input (world, bag, experiment).
        out: The user's `--out`, or None. An empty folder that exists is used as it is.

    Raises:
        UserError: If the folder cannot be made.
    """
    wanted = Path(out) if out is not None else Path("out") / f"{command}-{name}"
    folder, number = wanted, 1
    try:
        while folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            number += 1
            folder = wanted.with_name(f"{wanted.name}-{number}")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"cannot make the folder {folder}: {error.strerror}") from error
    if number > 1:
        print(f"{wanted} exists; results go to {folder}", file=sys.stderr)
    return folder


def write_atomic(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all."""
    data = content.encode() if isinstance(content, str) else content
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def write_summary(folder: Path, values: dict[str, Any]) -> Path:
    """Write `summary.json`: the common keys first, NaN, infinities and None as null.

    Args:
        folder: The result folder.
        values: The command's own keys; those of the common keys that it names replace ours
            (`command` and `ok` should be among them).
    """
    common: dict[str, Any] = {
        "command": None,
        "version": _version_of("floornav-common"),
        "seed": None,
        "machine": _machine(),
        "python": platform.python_version(),
        "packages": {name: _version_of(name) for name in _PACKAGES},
        "wall_s": round(time.monotonic() - _IMPORTED_AT, 3),
        "ok": None,
        "partial": False,
    }
    ordered = {key: values.get(key, common[key]) for key in _SUMMARY_HEAD}
    ordered.update((key, value) for key, value in values.items() if key not in ordered)
    path = folder / "summary.json"
    write_atomic(path, json.dumps(_plain(ordered), indent=2, allow_nan=False) + "\n")
    return path


@contextlib.contextmanager
def summary(
    folder: Path, *, command: str, seed: int | None, values: dict[str, Any]
) -> Iterator[dict[str, Any]]:
    """Give a dict to fill and write it as `summary.json`, however the block ends.

    Args:
        folder: The result folder.
        command: Name of the command.
        seed: Its seed, or None.
        values: Every key of the command with its value so far (None = not known yet).

    Yields:
        The dict; set `ok` to False for a run that ended badly without an exception.
    """
    filled = {"command": command, "seed": seed, "ok": True, "partial": False, **values}
    started = time.monotonic()
    try:
        yield filled
    except BaseException as error:
        filled["ok"] = False
        filled["partial"] = True
        filled["error"] = "interrupted" if isinstance(error, KeyboardInterrupt) else str(error)
        raise
    finally:
        filled["wall_s"] = round(time.monotonic() - started, 3)
        write_summary(folder, filled)


def write_html(folder: Path, title: str, sections: list[Section], subtitle: str = "") -> Path:
    """Write `report.html`, one self-contained page (pictures embedded, no scripts)."""
    path = folder / "report.html"
    write_atomic(path, render_page(title, sections, subtitle))
    return path


def run_command(main: Callable[[], int | None]) -> int:
    """Run a command's main and turn what happens into an exit code.

    A `UserError` is one line and 2; Ctrl-C or SIGTERM is one line and 1; any other exception
    shows its traceback and is 1.
    """
    # SIGINT too: a shell that starts a command in the background leaves it ignored.
    for signum in (signal.SIGINT, signal.SIGTERM):
        signal.signal(signum, _on_stop_signal)
    try:
        code = main()
        return 0 if code is None else code
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped; results so far are marked partial", file=sys.stderr)
        return 1
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception:
        traceback.print_exc()
        return 1


def _on_stop_signal(signum: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt


def _version_of(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _machine() -> str:
    model = platform.processor() or platform.machine()
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{model}, {cores} cores, {platform.system()} {platform.release()}"


def _plain(value: Any) -> Any:
    """Return the value as JSON can hold it: numpy as Python, not-finite numbers as None."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
