"""Prior widths that several parameters share, as the data tell them.

Terms of a quantity along the sheet that need not be there follow the noise under a wide prior, and
under a narrow one what is there is lost. How large they are is told by all of them together: the
likelihood of a width is averaged over all of them, each decade being as likely beforehand
(empirical Bayes: Efron and Morris 1973, MacKay 1992).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.identification.likelihood.mixed_model import Solution
from model.identification.likelihood.noise.row_covariance import Data
from model.measurements import FloatArray

LEAST_SHARE = 1e-4  # of the largest width; shapes show no less
STEPS = 25


@dataclass(frozen=True, kw_only=True)
class SharedWidth:
    """Parameters with priors of one width."""

    places: tuple[int, ...]
    largest: float
    width: float


def estimated_widths(
    shared: Sequence[SharedWidth], data: Data, solution: Solution
) -> tuple[SharedWidth, ...]:
    """Return the widths that data ask for, with scatter and noise as a solution has them."""
    weighed = solution.weights @ data.X
    rows = data.X.reshape(-1, data.X.shape[2])
    information = rows.T @ weighed.reshape(rows.shape)
    right_side = weighed.reshape(rows.shape).T @ data.y.ravel()
    precision, result = data.precision.copy(), list[SharedWidth]()
    for one in shared:
        at = list(one.places)
        widths = np.geomspace(LEAST_SHARE * one.largest, one.largest, STEPS)
        deviances = np.zeros(STEPS)
        for i, width in enumerate(widths):
            precision[at] = width**-2.0
            deviances[i] = _deviance(information, right_side, precision, data.away)
            deviances[i] += 2.0 * len(at) * np.log(width)
        likely = np.exp(-0.5 * (deviances - deviances.min()))
        width = float(np.exp(likely @ np.log(widths) / np.sum(likely)))
        precision[at] = width**-2.0
        result.append(replace(one, width=width))
    return tuple(result)


def _deviance(
    information: FloatArray, right_side: FloatArray, precision: FloatArray, away: FloatArray
) -> float:
    """-2 ln of the likelihood by the prior, of parameters by which it is integrated."""
    whole = information + np.diag(precision)
    scale = 1.0 / np.sqrt(np.diag(whole))
    scaled, towards = whole * scale[:, None] * scale, scale * (right_side - precision * away)
    _, logdet = np.linalg.slogdet(scaled)
    quadratic = float(towards @ np.linalg.solve(scaled, towards))
    return (
        float(logdet) - 2.0 * float(np.sum(np.log(scale))) - quadratic + float(precision @ away**2)
    )
