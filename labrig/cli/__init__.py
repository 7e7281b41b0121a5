"""The command line: one thin command per job."""

import os

# All matrices here are small: threads that share them only wait for one another, many times as long
# where other programs want the cores. Must be set before numpy is first loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

from labrig.cli.main import main

__all__ = ["main"]
