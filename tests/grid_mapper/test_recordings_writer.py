"""What a full disk leaves of a recording."""

import subprocess
import sys

import pytest
from recording_builders import NS, START_NS

from grid_mapper.recordings.bag import Bag

LIMIT_BYTES = 10 * 2**20
MESSAGE_BYTES = 100_000
FILL = f"""
import resource, sys
from pathlib import Path
from grid_mapper.recordings.bag_writer import WRITE_ERRORS, BagWriter
resource.setrlimit(resource.RLIMIT_FSIZE, ({LIMIT_BYTES}, {LIMIT_BYTES}))
writer = BagWriter(Path(sys.argv[1]), sys.argv[2])
writer.add_topic("/big", "std_msgs/msg/String")
try:
    for i in range(int(sys.argv[3])):
        writer.write("/big", {START_NS} + i * {NS}, bytes({MESSAGE_BYTES}))
except WRITE_ERRORS:
    writer.keep()
    sys.exit(3)
try:
    writer.close()
except WRITE_ERRORS:
    sys.exit(4)
"""


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("num_messages", [90, 104, 300])
def test_what_was_written_before_the_disk_was_full_is_a_readable_bag(
    tmp_path, storage, num_messages
):
    command = [sys.executable, "-c", FILL, str(tmp_path / "bag"), storage, str(num_messages)]
    code = subprocess.run(command, check=False, timeout=60).returncode
    assert code in ((0,) if num_messages == 90 else (0, 3, 4))
    assert [p.name for p in tmp_path.iterdir()] == ["bag"]
    with Bag(tmp_path / "bag") as bag:
        stamps = [message.recorded_ns for message in bag.messages()]
    num_whole = num_messages if code == 0 else 40
    assert num_whole <= len(stamps) <= num_messages
    assert stamps == [START_NS + i * NS for i in range(len(stamps))]
    assert code != 0 or bag.problems == []
