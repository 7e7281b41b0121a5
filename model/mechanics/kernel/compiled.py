"""How everything of this folder is compiled, and kept on disk from one start to the next."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np

Array = np.ndarray[Any, Any]
_Function = TypeVar("_Function", bound=Callable[..., Any])
_HERE = Path(__file__).parent
_ARGUMENTS = ("collocation.py", "equilibrium.py")  # whose tuples are handed to compiled code


def compiled(function: _Function) -> _Function:
    """numba.njit, kept on disk: compiled once a machine, free of the interpreter's lock."""
    make = numba.njit(
        cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"}
    )
    return cast("_Function", make(function))


def _drop_stale(kept: Path) -> None:
    """Remove what was compiled from other sources than these.

    numba notices changes of the file a function stands in, not of those it calls in other files.
    """
    sources = [*sorted(_HERE.glob("*.py")), *(_HERE.parent / name for name in _ARGUMENTS)]
    stamp = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    mark = kept / "sources.txt"
    try:
        if mark.exists() and mark.read_text(encoding="ascii") == stamp:
            return
        for old in kept.glob("*.nb[ic]"):
            old.unlink(missing_ok=True)
        kept.mkdir(parents=True, exist_ok=True)
        mark.write_text(stamp, encoding="ascii")
    except OSError:
        return  # nothing is kept where nothing can be written


@compiled
def _nothing() -> None:
    pass


# numba's own choice: beside the sources, or in the user's cache where those cannot be written
_drop_stale(Path(cast("Any", _nothing).stats.cache_path))
