"""One thread for linear algebra: matrices here are small, and a second thread doubles the CPU time of a command.

A module of its own because it must be imported before numpy, which reads the variables when it is loaded.
"""

from __future__ import annotations

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Each of the libraries that numpy may be built with has one of its own."""


def use_one_thread() -> None:
    """Set the variables of this process and its children; one that the user has set stays."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")
