"""A model whose parameters deviate together, as `model.sheet.deviations` says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from model.mechanics.field import legendre_field
from model.sheet.beam_problem import ActiveEffect
from model.sheet.configured_sheet import Along
from model.sheet.deviations import STIFFNESS, curvature_key, effect_key, eibm_key, form_key
from model.sheet.sheet_model import SheetModel

NODES = 51  # of a quantity that was the same everywhere
MOST_TERMS = 16  # of a quantity along the sheet


def deviated(
    model: SheetModel, configuration: str, change: Mapping[str, float], sign: float
) -> SheetModel:
    """Return the model with changes of its parameters, times a sign."""
    one = model.sheet(configuration)
    length_m = model.cut_from_m.get(configuration, one.sheet.free_length_m)

    def terms(keys: Iterator[str]) -> dict[int, float]:
        return {k: sign * change[key] for k, key in enumerate(keys) if key in change}

    B = one.B.value + sign * change.get(STIFFNESS, 0.0)
    rest = _along(one.rest, length_m, terms(curvature_key(k) for k in range(MOST_TERMS)))
    eibm = {
        v: _along(along, length_m, terms(eibm_key(v, k) for k in range(MOST_TERMS)))
        for v, along in one.eibm.items()
    }
    sheet = replace(one, B=replace(one.B, value=B), rest=rest, eibm=eibm)
    effects = tuple(
        _effect(effect, place, configuration, change, sign)
        for place, effect in enumerate(model.effects)
    )
    sheets = {**model.sheets, configuration: sheet}
    return replace(model, sheets=sheets, effects=effects, deviations={})


def _along(along: Along, length_m: float, terms: Mapping[int, float]) -> Along:
    """Return a quantity with Legendre polynomials added to it."""
    if not terms:
        return along
    s = along.s_m
    if len(s) == 1 and set(terms) != {0}:
        s = np.linspace(0.0, length_m, NODES)
    added = sum(much * legendre_field(k, length_m)(s) for k, much in terms.items())
    values = np.interp(s, along.s_m, along.values) + added
    return replace(along, s_m=s, values=values, sigma=np.zeros(len(s)))


def _effect(
    effect: ActiveEffect, place: int, configuration: str, change: Mapping[str, float], sign: float
) -> ActiveEffect:
    """Return an effect with its parameters, and the nodes of its form, changed."""
    moved = effect.moved(
        configuration,
        {
            name: sign * change[key]
            for name in effect.names(configuration)
            if (key := effect_key(place, name)) in change
        },
    )
    form = []
    for j, term in enumerate(moved.form):
        nodes = (form_key(place, j, i) for i in range(len(term.values)))
        added = [sign * change.get(key, 0.0) for key in nodes]
        values = tuple(v + a for v, a in zip(term.values, added, strict=True))
        form.append(replace(term, values=values))
    return replace(moved, form=tuple(form))
