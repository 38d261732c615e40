"""One thread a node for what OpenCV, numba and BLAS would else spread over all cores."""

from __future__ import annotations

import os
import sys

_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def limit_threads(num_threads: int) -> None:
    """Limit the libraries that are loaded, and through the environment those that come later.

    BLAS that is already loaded can only be told through `threadpoolctl`; without it the
    environment the process was started with decides.
    """
    for name in _VARIABLES:
        os.environ.setdefault(name, str(num_threads))
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(num_threads)
    if "numba" in sys.modules:
        numba = sys.modules["numba"]
        numba.set_num_threads(min(num_threads, numba.config.NUMBA_NUM_THREADS))
    else:
        # Once numba runs it refuses to see its variable changed.
        os.environ.setdefault("NUMBA_NUM_THREADS", str(num_threads))
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return
    threadpool_limits(num_threads)
