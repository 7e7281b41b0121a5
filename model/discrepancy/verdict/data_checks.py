"""Remarks on oddities in data that can still be fitted."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from model.discrepancy.search.order_of_positions import positions_in_order
from model.discrepancy.thresholds import SLIP_LENGTH_RATIO
from model.discrepancy.verdict.result import Unknown
from model.identification.data.run_key import run_key
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import Measurements

# effects that go with the time of the session, or begin at a position
COURSES = frozenset({"eibm_drift", "force_drift", "roll_sticking", "stiffness_drift"})


def remarks(measurements: Measurements, base: MixedModelFit) -> Iterator[str]:
    """Yield one sentence for each oddity."""
    yield from _out_of_reach(base)
    yield from _of_no_run(measurements)
    yield from _without_curves(measurements)
    yield from _wetting(measurements)


def place_or_time(
    base: MixedModelFit, names: Collection[str], unknown: Unknown | None
) -> Iterator[str]:
    """Yield that what goes with the place may go with the time, where either was found.

    Of one sheet at positions in their order; a second one has other times at the same places.
    """
    sheets = base.problem.forward.data_vectors
    found = not COURSES.isdisjoint(names)
    if unknown is not None:
        found |= unknown.along in ("position", "time")
    if found and len(sheets) == 1 and positions_in_order(sheets):
        yield (
            "the positions were measured one after the other, so what goes with the place may as"
            " well go with the time; measure some of them again, in another order"
        )


def _wetting(measurements: Measurements) -> Iterator[str]:
    """Where times were recorded, but not when the sheet was moistened."""
    kept = [r for c in measurements.conditions for r in c.readings if r.kind == "kept" and r.valid]
    timed = [r for r in kept if r.session_s is not None]
    if any(r.wetted_s is None for r in timed):
        yield (
            "it is not known when the sheet was moistened: what dries or drifts since the last"
            " wetting counts from the beginning of each run"
        )


def _out_of_reach(base: MixedModelFit) -> Iterator[str]:
    forward = base.problem.forward
    for c, state in enumerate(base.linear.states):
        configuration_model = forward.configuration_models[c]
        whole = configuration_model.sheet.free_length_m + configuration_model.sheet.elongation_m
        far = state.solved.contact.s_hat_m > SLIP_LENGTH_RATIO * whole
        for at_m in np.unique(
            configuration_model.stated_m[far & np.isfinite(configuration_model.stated_m)]
        ):
            yield (
                f"'{forward.names[c]}' cannot reach {at_m * 1e3:g} mm in the model: it would slip"
                " out of the rolls before"
            )


def _of_no_run(measurements: Measurements) -> Iterator[str]:
    known = {run_key(c)[:3] for c in measurements.conditions}
    for series in measurements.series:
        if series.position_m is None or series.extra:
            continue
        if run_key(series)[:3] not in known:
            yield (
                f"the series of '{series.configuration}' at {series.position_m * 1e3:g} mm is left"
                " out: no force was measured there"
            )


def _without_curves(measurements: Measurements) -> Iterator[str]:
    """Where most curves of a sheet are missing, and there are some in these measurements."""
    if all(one.curve is None for one in measurements.conditions):
        return
    for name in measurements.sheets:
        own = [one for one in measurements.conditions if one.configuration == name]
        without = sum(one.curve is None for one in own)
        if without > len(own) / 2:
            yield (
                f"'{name}' has no curve in {without} of {len(own)} conditions, so that its shape"
                " says little; where one was refused, `labrig analyze` says why"
            )
