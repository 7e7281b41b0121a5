"""The command line: one thin command per job."""

import os
import sys

# All matrices here are small: threads that share them only wait for one another, many times as long
# where other programs want the cores. Must be set before numpy is first loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")
# Figures go into files. A notebook names a back end that may not be installed beside labrig.
os.environ["MPLBACKEND"] = "agg"

_lost: list[object] = []


def _note_lost(unraisable: "sys.UnraisableHookArgs") -> None:
    """Note a Ctrl-C in a callback of the imports: Python prints a traceback and continues."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        _lost.append(unraisable.exc_type)
    else:
        _as_before(unraisable)


_as_before, sys.unraisablehook = sys.unraisablehook, _note_lost
try:
    from labrig.cli.main import main

    if _lost:
        raise KeyboardInterrupt
except KeyboardInterrupt:  # Ctrl-C before there is a program that could tell of it
    sys.stderr.write("labrig: stopped.\n")
    raise SystemExit(4) from None  # `ExitCode.STOPPED`
finally:
    sys.unraisablehook = _as_before

__all__ = ["main"]
