"""The parameters of a diagnosis: those estimated, and the forms chosen among several."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from labrig.report.parts.table import Table, interval, with_sigma
from model import Parameter
from model.discrepancy.verdict.result import Diagnosis, Named
from model.effects import EffectParameter, catalogue, title

_BASE = {"B_Nm2": "bending stiffness B"}
MOST_SHARE = 0.999  # beyond that a share is "more than 99.9 %"


def percent(share: float) -> str:
    """Return a probability or share, never rounded to all or nothing."""
    if share > MOST_SHARE:
        return f"more than {100 * MOST_SHARE:g} %"
    if 0.0 < share < 1.0 - MOST_SHARE:
        return f"less than {100 * (1.0 - MOST_SHARE):.1g} %"
    return f"{100 * share:.3g} %"


def parameter_table(found: Diagnosis) -> Table | None:
    """Return the effects' parameters that are estimated, and B and EIBM of the base model."""
    rows = [row for one in found.effects for row in _effect_rows(one)]
    rows += [
        (f"{name}: {_quantity(key)}", *_cells(p), "-", "-")
        for name, parts in found.base.items()
        for key, p in parts.items()
    ]
    if not rows:
        return None
    columns = (
        "parameter", "value", "90 % interval", "unit", "probability of the effect",
        "model-form error",
    )  # fmt: skip
    note = "EIBM: constant, without the effects."
    if any(one.name == "nonuniform_eibm" for one in found.effects):
        note = "EIBM: mean over [0, l], without the other effects."
    if found.effects:
        note += " Model-form error: share of the effect that its formula does not describe."
    return Table(title="Parameters", columns=columns, rows=tuple(rows), note=note)


def _quantity(key: str) -> str:
    """Return the name of a base parameter: "EIBM +2 V" is EIBM at +2 V."""
    return _BASE.get(key, key.replace("EIBM ", "EIBM at "))


def _effect_rows(one: Named) -> Iterator[tuple[str, ...]]:
    own = [(f", {conf}", parts) for conf, parts in one.by_configuration.items()]
    choices = {parameter.name for parameter in _choices(one)}
    for suffix, parts in own or [("", one.parameters)]:
        for key, p in parts.items():
            if key not in choices:
                probability, form = percent(one.probability), percent(one.form_share)
                yield (
                    f"{title(one.name)}{suffix}: {in_words(key, p.unit)}",
                    *_cells(_bounded(one, key, p)),
                    probability,
                    form,
                )


def _bounded(one: Named, key: str, parameter: Parameter) -> Parameter:
    """Return the parameter with the catalogue's bounds, which older diagnoses do not hold."""
    known = catalogue()
    if one.name not in known or math.isfinite(parameter.low) or math.isfinite(parameter.high):
        return parameter
    bounds = {p.name: (p.low, p.high) for p in known[one.name].parameters}
    low, high = bounds.get(key, (parameter.low, parameter.high))
    return replace(parameter, low=low, high=high)


def _choices(one: Named) -> tuple[EffectParameter, ...]:
    known = catalogue()
    return known[one.name].choices if one.name in known else ()


def choice_table(found: Diagnosis) -> Table | None:
    """Return what is chosen among the forms of each effect, with its posterior probability."""
    rows = tuple(
        row
        for one in found.effects
        for parameter in _choices(one)
        for row in _choice(one, parameter)
    )
    if not rows:
        return None
    note = "Posterior probability of each choice, given that the effect acts."
    columns = ("choice", "chosen", "probability", "alternatives")
    return Table(title="Choices of form", columns=columns, rows=rows, note=note, text=True)


def _choice(one: Named, parameter: EffectParameter) -> Iterator[tuple[str, ...]]:
    chosen = one.choices.get(parameter.name)
    name = f"{title(one.name)}: {in_words(parameter.name, parameter.unit)}"
    if chosen is not None:
        others = "; ".join(f"{what} ({percent(share)})" for what, share in chosen.alternatives)
        yield name, chosen.meaning, percent(chosen.probability), others or "-"
    elif parameter.name in one.parameters:  # of a diagnosis that an older version stored
        yield name, parameter.meaning_of(one.parameters[parameter.name].value), "-", "-"


def in_words(name: str, unit: str) -> str:
    """Return the name of a parameter as readers are shown it, beside its unit."""
    return name.removesuffix(f"_{unit}").replace("_", " ")


def _cells(parameter: Parameter) -> tuple[str, str, str]:
    factor, unit = readable(parameter.unit)
    p = parameter.scaled(factor, unit)
    return with_sigma(p.value, p.sigma), interval(*p.interval()), unit or "-"


def readable(unit: str) -> tuple[float, str]:
    """Return a factor and the customary unit of an SI quantity."""
    return {
        "N m^2": (1e6, "µN·m²"), "N m": (1e6, "µN·m"), "N": (1e3, "mN"), "Pa": (1e-6, "MPa"),
        "m": (1e3, "mm"),
    }.get(unit, (1.0, unit))  # fmt: skip
