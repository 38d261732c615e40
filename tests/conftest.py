"""For all tests: no ROS here, so that the tests of the cores run without it."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Kernels compile on the first call and machines are busy: drawn examples take their time.
settings.register_profile("busy", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("busy")

# Domains up to 101 keep clear of the ports that Linux gives out; tests/graph uses 60 to 99.
DOMAINS = range(10, 60)

# Tests never talk to other hosts.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


@pytest.fixture
def ros_domain_id(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Return a ROS domain that no other test has, in this process or another; also set it."""
    for number in DOMAINS:
        path = Path(tempfile.gettempdir()) / f"floornav-test-domain-{os.getuid()}-{number}.lock"
        with open(path, "w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
            yield number
            return
    pytest.fail(f"no free ROS domain in {DOMAINS}")


@pytest.fixture
def repository() -> Path:
    """Return the folder of the checkout."""
    return Path(__file__).resolve().parent.parent
