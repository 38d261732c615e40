"""Separate hosts on one machine: network namespaces with a cable between them that we make.

Each host has a network, a host name, shared memory and a /tmp of its own, so that DDS takes it for
what it is: another machine. Both ends of the cable lie in a third namespace, where `lossy_link.py`
carries frames from one to the other.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

LINK = Path(__file__).with_name("lossy_link.py")
# A host's own shared memory and name, kept by a process that others join.
_OWN = "mount -t tmpfs none /dev/shm && hostname $0 && echo kept && exec sleep 3600"


def why_not() -> str:
    """Return why no hosts can be made here; "" if they can."""
    for tool in ("ip", "unshare", "nsenter", "mount"):
        if shutil.which(tool) is None:
            return f"the command '{tool}' is missing"
    name = f"fnav-try-{os.getpid()}"
    made = _run("ip", "netns", "add", name)
    if made.returncode:
        return f"network namespaces may not be made: {made.stderr.strip()}"
    own = _OWN.replace("3600", "0")
    tried = _run("ip", "netns", "exec", name, "unshare", "-mui", "sh", "-c", own, name)
    veth = _run(
        "ip", "-n", name, "link", "add", "name", "veth0", "type", "veth", "peer", "name", "veth1"
    )
    _run("ip", "netns", "delete", name)
    for each, what in ((tried, "mounts of their own"), (veth, "pairs of network devices")):
        if each.returncode:
            return f"{what} may not be made: {each.stderr.strip()}"
    return ""


class TwoHosts:
    """Two hosts, `a` at 10.77.0.1 and `b` at 10.77.0.2, and the cable's namespace between."""

    ADDRESSES: ClassVar = {"a": "10.77.0.1", "b": "10.77.0.2"}

    def __init__(self) -> None:
        """Make them."""
        tag = f"fnav{os.getpid()}"
        self.cable = f"{tag}-cable"
        self.hosts = {side: f"{tag}-{side}" for side in ("a", "b")}
        _must("ip", "netns", "add", self.cable)
        for side, host in self.hosts.items():
            _must("ip", "netns", "add", host)
            _must(
                "ip", "-n", host, "link", "add", "name", "eth0", "type", "veth",
                "peer", "name", f"to_{side}", "netns", self.cable,
            )  # fmt: skip
            _must("ip", "-n", host, "address", "add", f"{self.ADDRESSES[side]}/24", "dev", "eth0")
            for device in ("lo", "eth0"):
                _must("ip", "-n", host, "link", "set", device, "up")
            _must("ip", "-n", host, "route", "add", "default", "dev", "eth0")
            _must("ip", "-n", self.cable, "link", "set", f"to_{side}", "up")
        self._keepers = {side: _keep(host) for side, host in self.hosts.items()}

    def keeper(self, side: str) -> int:
        """Return the process that keeps what is a host's own."""
        return self._keepers[side].pid

    def join(self, side: str, command: Sequence[str]) -> list[str]:
        """Return the command that runs another one on a host."""
        return joined(self.keeper(side), command)

    def command(self, side: str, *words: str | Path) -> list[str]:
        """Return the command that runs a python script on a host."""
        return self.join(side, [sys.executable, *map(str, words)])

    def link_command(self, *words: str) -> list[str]:
        """Return the command of the cable."""
        return link_command(self.cable, *words)

    def remove(self) -> None:
        """Take them away; their processes have ended."""
        for keeper in self._keepers.values():
            keeper.kill()
            keeper.communicate()
        for name in (*self.hosts.values(), self.cable):
            _run("ip", "netns", "delete", name)


def joined(keeper: int, command: Sequence[str]) -> list[str]:
    """Return the command that runs another one on the host of a process that keeps it."""
    return ["nsenter", "-t", str(keeper), "-m", "-u", "-i", "-n", *command]


def link_command(cable: str, *words: str) -> list[str]:
    """Return the command that carries frames between the devices of a cable's namespace."""
    devices = ["to_a", "to_b"]
    return ["ip", "netns", "exec", cable, sys.executable, str(LINK), *devices, *words]


def _keep(host: str) -> subprocess.Popen[str]:
    """Start the process that keeps what is a host's own."""
    command = ["ip", "netns", "exec", host, "unshare", "-mui", "sh", "-c", _OWN, host]
    keeper = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    if keeper.stdout is None or keeper.stdout.readline() != "kept\n":
        raise RuntimeError(f"{host}: its own mounts could not be made")
    return keeper


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(words, capture_output=True, text=True)


def _must(*words: str) -> None:
    done = _run(*words)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip()}")
