"""What the checks of left-out residuals share."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.families import Family, families, joined
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.thresholds import LEFT_OUT_CHI2_RATIO, LEFT_OUT_SIGMA


def too_large(
    named: NamedModel, kind: Callable[[Family], str], chosen: Callable[[Family], bool]
) -> Iterator[Failure]:
    """Yield a failure for each kind of family whose left-out residuals exceed the noise.

    The noise is that of the repeats, with scatter between set-ups as it usually is at most.
    """
    some = [f for f in families(named.fitted, named.outcome.outliers) if chosen(f)]
    for name in dict.fromkeys(kind(f) for f in some):
        chi2, count = named.predictive.chi2(joined([f for f in some if kind(f) == name]))
        if not count:
            continue
        ratio, sigma = chi2 / count, (chi2 - count) / np.sqrt(2.0 * count)
        if ratio > LEFT_OUT_CHI2_RATIO and sigma > LEFT_OUT_SIGMA:
            yield Failure(
                consequence=Consequence.REJECT,
                sentence=(
                    f"{name}: the error on left-out positions is {np.sqrt(ratio):.1f} times what"
                    " noise and usual scatter allow"
                ),
            )
