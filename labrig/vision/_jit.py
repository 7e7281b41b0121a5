"""numba's compiler with its types kept: compiled once, cached on disk, free of the GIL."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

# sums in any order; what is not a number stays that
FASTER = {"reassoc", "contract", "arcp", "nsz"}
Function = TypeVar("Function", bound=Callable[..., object])


def jit(function: Function) -> Function:
    """The function, compiled at its first call."""
    options = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": FASTER}
    return cast("Function", numba.njit(**options)(function))
