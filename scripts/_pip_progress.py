"""Run pip inside an environment: quiet when it works, its own words when it does not.

Standard library only; syntax that Python 3.9 reads.
"""

import re
import subprocess
from pathlib import Path

from _environment import clean_child_environment

SHOWN_LINES = 12
NOISE = re.compile(
    r"^\s*(Collecting|Downloading|Using cached|Looking in|Requirement already|\[notice\])"
)


def pip_install(prefix, lock, report, error_class):
    """Install a hashed lock into the environment at `prefix`.

    Args:
        prefix: The environment.
        lock: Requirements file in which every package is pinned and hashed.
        report: Called with a short text while it goes on.
        error_class: Raised with pip's last words if it fails; the whole output is in
            `<prefix>/pip.log`.
    """
    command = [str(Path(prefix) / "bin" / "python"), "-m", "pip", "install", "--require-hashes"]
    command += ["--no-input", "--disable-pip-version-check", "--progress-bar", "off"]
    environ = clean_child_environment()
    environ.update(PYTHONUNBUFFERED="1", PIP_NO_COLOR="1")
    environ.pop("PYTHONPATH", None)
    lines = []
    pip = subprocess.Popen(
        [*command, "-r", str(lock)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=environ,
        text=True,
    )
    try:
        with pip, open(Path(prefix) / "pip.log", "w") as log:
            for line in _reported(pip.stdout, lock, report):
                lines.append(line.rstrip())
                log.write(line)
    except BaseException:
        pip.kill()
        raise
    if pip.returncode != 0:
        words = [line for line in lines if line.strip() and not NOISE.match(line)]
        raise error_class("\n".join([f"pip failed ({prefix}/pip.log):", *words[-SHOWN_LINES:]]))


def _reported(lines, lock, report):
    """Pass on pip's lines, and report how far it is."""
    total = sum(1 for line in Path(lock).read_text().splitlines() if re.match(r"[A-Za-z0-9]", line))
    num_fetched = 0
    for line in lines:
        if line.startswith("Collecting "):
            num_fetched += 1
            report(f"{num_fetched} of about {total} packages fetched")
        elif line.startswith("Installing collected"):
            report("unpacking")
        yield line
