"""Lets the mapper's tests import their worlds."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from hypothesis import settings  # noqa: E402

settings.register_profile("kernels", deadline=None)  # the first call compiles
settings.load_profile("kernels")
