"""What an environment says of itself: which version of each of its layers is there.

Standard library only, and syntax that Python 3.9 reads.
"""

import hashlib
import json
from pathlib import Path

STAMP = "floornav-environment.json"


def read_stamp(prefix):
    """Return what the environment says of itself; empty if it says nothing readable."""
    try:
        return json.loads((Path(prefix) / STAMP).read_text())
    except (OSError, ValueError):
        return {}


def write_stamp(prefix, stamp):
    """Write the stamp whole or not at all."""
    new = Path(prefix) / f"{STAMP}.new"
    new.write_text(json.dumps(stamp, indent=1) + "\n")
    new.replace(Path(prefix) / STAMP)


def digest(*parts):
    """Hash byte strings."""
    result = hashlib.sha256()
    for part in parts:
        result.update(len(part).to_bytes(8, "big") + part)
    return result.hexdigest()
