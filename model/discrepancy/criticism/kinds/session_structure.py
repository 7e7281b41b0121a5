"""A named effect that goes with the session, within each configuration and between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.group_amplitudes import GroupAmplitude, amplitudes
from model.discrepancy.criticism.named_model import NamedModel, limited_scatter
from model.discrepancy.search.form_share import steps_of
from model.discrepancy.thresholds import LEAST_RIGID_RATIO, STRUCTURE_SIGMA
from model.effects import title
from model.measurements import FloatArray


@dataclass(frozen=True)
class SessionStructure(VerdictCheck):
    """What drifts from one configuration to the next drifts within each of them.

    A constant that each configuration has of its own is no drift, though a bent one imitates it.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        for index, one in enumerate(named.fitted.found):
            slow = "session" in one.effect.form_error_along
            if one not in named.found or not slow or len(named.fitted.problem.forward.names) < 2:
                continue
            within, between = _factors(named, index)
            sigma = float(np.hypot(within.sigma, LEAST_RIGID_RATIO * between.sigma))
            missing = LEAST_RIGID_RATIO * between.factor - within.factor
            if missing > STRUCTURE_SIGMA * sigma:
                yield Failure(
                    consequence=Consequence.REJECT,
                    sentence=(
                        f"{title(one.effect.name)} is {between.factor:.2f} ± {between.sigma:.2f}"
                        " between the configurations, over what is named, but"
                        f" {within.factor:.2f} ± {within.sigma:.2f} within them: each"
                        " configuration has a constant of its own"
                    ),
                    effects=(one.effect.name,),
                )


def _factors(named: NamedModel, index: int) -> tuple[GroupAmplitude, GroupAmplitude]:
    """Return the factors of an effect's course within configurations, and of their means."""
    fitted = named.fitted
    forward = fitted.problem.forward
    whole, means = np.zeros(forward.row_index.size), np.zeros(forward.row_index.size)
    for c, step in steps_of(fitted, index):
        level = replace(step, force_N=_level(step.force_N), eibm=_level(step.eibm),
                        stiffness=_level(step.stiffness))  # fmt: skip
        whole += forward.rows_of(c, fitted.linear.states[c], step)
        means += forward.rows_of(c, fitted.linear.states[c], level)
    columns = {"within": whole - means, "between": means}
    within, between = amplitudes(fitted, index, columns, limited_scatter(fitted))
    return within, between


def _level(values: FloatArray) -> FloatArray:
    return np.full_like(values, np.mean(values) if values.size else 0.0)


CHECK = SessionStructure(
    name="session_structure",
    meaning="what drifts between configurations drifts within them",
    order=44,
)
