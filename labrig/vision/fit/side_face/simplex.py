"""The least of a cost of few parameters, of which some are held."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def lowest(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    steps: FloatArray,
    used: slice,
    evaluations: int,
) -> FloatArray:
    """Return the parameters of least cost by a simplex from `start`.

    Only those `used` are moved.
    """
    from scipy import optimize

    def whole(part: FloatArray) -> FloatArray:
        out = start.copy()
        out[used] = part
        return out

    first = start[used]
    simplex = first + np.vstack([np.zeros(len(first)), np.diag(steps[used])])
    options: Any = {"initial_simplex": simplex, "maxfev": evaluations}
    minimize: Any = optimize.minimize
    best = minimize(lambda part: cost(whole(part)), first, method="Nelder-Mead", options=options)
    return whole(np.asarray(best.x, dtype=np.float64))
