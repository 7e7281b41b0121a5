"""Whether set-ups that seem to scatter follow the position or the course of the session.

Chance has no order: what goes with a coordinate is something that the model lacks.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from model.discrepancy.thresholds import (
    EVIDENCE_THRESHOLD_LN,
    EXCESSIVE_MOUNTING_RATIO,
    EXCESSIVE_SCATTER_RATIO,
)
from model.discrepancy.verdict.messages import DIFFERS, scattered
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.random_effects import ASSUMED
from model.measurements import FloatArray

# where camera and sheet are after each set-up: how far off depends on the rig
MOUNTED = ("registration", "clamp_tilt")
COORDINATES = {"position": "the position", "session": "the time in the session"}


def unusual_scatter(fitted: MixedModelFit) -> str:
    """Return the message that set-ups differ by more than is usual; empty: they do not."""
    log_ratio = fitted.solution.log_sigma - fitted.problem.guess
    times = dict(zip(ASSUMED, np.exp(log_ratio).tolist(), strict=False))
    for name in sorted(DIFFERS, key=lambda one: -times[one]):
        if times[name] < EXCESSIVE_SCATTER_RATIO:
            break
        follows = followed(fitted, name)
        if name not in MOUNTED or follows or times[name] > EXCESSIVE_MOUNTING_RATIO:
            return scattered(name, times[name], follows)
    return ""


def followed(fitted: MixedModelFit, name: str) -> tuple[str, float] | None:
    """Return what a scatter follows within the configurations, with its correlation.

    None: nothing, as a straight line has to be worth as much evidence as a name.
    """
    worth = []
    places = product(_coordinates(fitted).items(), fitted.added()[name].T)
    for (what, at), found in places:
        use = np.isfinite(at[:, 1])
        count, value = int(use.sum()), _correlation(at[use, 0], at[use, 1], found[use])
        gain = -0.5 * (count * np.log1p(-min(value**2, 1.0 - 1e-9)) + np.log(max(count, 1)))
        worth.append((float(gain), COORDINATES[what], value))
    gain, what, value = max(worth)
    return (what, value) if gain > EVIDENCE_THRESHOLD_LN else None


def _coordinates(fitted: MixedModelFit) -> dict[str, FloatArray]:
    """Return for each run its configuration and the coordinate; NaN where there is none: (R, 2)."""
    forward = fitted.problem.forward
    runs = forward.row_index.runs
    result = {what: np.full((len(runs), 2), np.nan) for what in COORDINATES}
    for c, data_vector in enumerate(forward.data_vectors):
        for run in {one.run for one in data_vector.seen}:
            own = [one for one in data_vector.seen if one.run == run]
            time = float(np.mean([np.mean(one.clock.session) for one in own]))
            r = runs.index(run)
            result["position"][r] = c, own[0].position_m
            result["session"][r] = c, time
    return result


def _correlation(group: FloatArray, at: FloatArray, found: FloatArray) -> float:
    """Return the correlation within the groups; 0 where there is no course."""
    a, b = at.copy(), found.copy()
    for one in np.unique(group):
        own = group == one
        a[own] -= np.mean(a[own])
        b[own] -= np.mean(b[own])
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0.0 else 0.0
