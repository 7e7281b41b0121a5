"""numba's compiler with its types kept: compiled once, cached on disk, free of the GIL."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])


def jit(function: Function) -> Function:
    """The function, compiled at its first call."""
    return cast("Function", numba.njit(cache=True, nogil=True, error_model="numpy")(function))
