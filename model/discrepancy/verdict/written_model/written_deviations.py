"""How the parameters of a diagnosed model, its effects and their forms are uncertain together."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from model.discrepancy.verdict.written_model.effect_uncertainty import uncertainties
from model.discrepancy.verdict.written_model.written_form import by_ways
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import Found
from model.sheet.deviations import (
    STIFFNESS,
    Deviations,
    columns_of,
    effect_key,
    eibm_key,
    few_changes,
    form_key,
)

Places = dict[str, dict[int, float]]  # by row: how much a place of the fit's parameters changes it


def deviations(final: MixedModelFit, c: int) -> Deviations:
    """Return those of a configuration: of B, the mean EIBMs, and the effects that act in it."""
    rows = dict(_of_sheet(final, c))
    for place, one in enumerate(final.found):
        rows |= dict(_of_effect(final, c, place, one))
    used = sorted({i for row in rows.values() for i in row})
    columns = columns_of(final.covariance[np.ix_(used, used)])
    moves = {i: columns[k] for k, i in enumerate(used)}
    made = {
        key: np.asarray(sum(much * moves[i] for i, much in row.items()), dtype=float)
        for key, row in rows.items()
        if row
    }
    changes = final.spread.changes(final.solution.covariance, used, columns)
    return Deviations(made, few_changes(changes))


def _of_sheet(final: MixedModelFit, c: int) -> Iterator[tuple[str, dict[int, float]]]:
    part, theta = final.problem.bases.parts[c], final.theta
    B = float(np.exp(theta[part.stiffness]))
    yield STIFFNESS, {part.stiffness: B}
    for volts, (i, sign) in part.eibm.items():
        yield eibm_key(volts, 0), {part.stiffness: sign * B * float(theta[i]), i: sign * B}


def _of_effect(
    final: MixedModelFit, c: int, place: int, one: Found
) -> Iterator[tuple[str, dict[int, float]]]:
    """Yield the parameters' rows, as uncertain as they are stated, and those of the form."""
    name, span = final.problem.forward.names[c], final.spans[place]
    if name not in one.values:
        return
    for key, unsure in uncertainties(final, place, name).items():
        own = float(np.sqrt(final.covariance[unsure.column, unsure.column]))
        yield effect_key(place, key), {unsure.column: unsure.sigma / own}
    first = span.start + len(one.parameters())
    for j, by in enumerate(by_ways(one)):
        for node, row in enumerate(by):
            yield form_key(place, j, node), dict(enumerate(row.tolist(), first))
