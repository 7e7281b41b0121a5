"""Diagnose the rest of the measurements after the dynamics are subtracted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from model.discrepancy.at_rest.at_rest import AtRest
from model.discrepancy.at_rest.taken import DynamicsTaken
from model.discrepancy.verdict.messages import listed
from model.discrepancy.verdict.result import Diagnosis
from model.dynamics import DynamicSheet
from model.effects import title
from model.effects.catalogue import catalogue
from model.measurements import Measurements
from model.sheet.beam_problem import ActiveEffect
from model.sheet.configured_sheet import ConfiguredSheet
from model.sheet.sheet_model import SheetModel


def with_dynamics(
    found: Diagnosis, rested: AtRest, measured: Measurements, model: SheetModel
) -> Diagnosis:
    """Return a diagnosis of corrected measurements with what was taken off them.

    Its model has the dynamics, with the stiffness and EIBM that were found.
    """
    taken = rested.dynamics
    if not taken:
        return found
    sheets = listed([f"'{name}'" for name in taken])
    deviating = [name for name in deviations() if name in {one.name for one in found.effects}]
    text = f"The base model has the dynamics of {sheets}."
    if deviating:
        names = listed([title(name) for name in deviating])
        text += f" What is called {names} is what they do not explain."
    notes = [f"the dynamics of '{name}' explain {one.sentence}" for name, one in taken.items()]
    return replace(
        found, sentence=f"{found.sentence} {text}", notes=(*found.notes, *notes), dynamics=taken,
        model=_with_dynamics(found.model, taken, measured, model),
    )  # fmt: skip


def deviations() -> tuple[str, ...]:
    """Return the names of the effects that dynamics have a part of."""
    return tuple(name for name, one in catalogue().items() if one.explained_by_dynamics)


def _with_dynamics(
    found: SheetModel, taken: Mapping[str, DynamicsTaken], measured: Measurements, given: SheetModel
) -> SheetModel:
    sheets = {
        name: replace(
            one, sheet=replace(one.sheet, rise_time_s=measured.sheets[name].rise_time_s)
        )
        for name, one in found.sheets.items()
    }  # fmt: skip
    dynamic = {
        name: _scaled(given.dynamic[name], sheets[name], taken[name])
        if name in taken
        else given.dynamic[name]
        for name in sheets
        if name in given.dynamic
    }
    effects = tuple(_marked(one, tuple(taken)) for one in found.effects)
    return replace(found, sheets=sheets, dynamic=dynamic, effects=effects)


def _scaled(dynamic: DynamicSheet, found: ConfiguredSheet, taken: DynamicsTaken) -> DynamicSheet:
    """Return dynamics whose moment per volt makes the EIBM that was found."""

    def factor(sign: float) -> float:
        own = [v for v in found.eibm if v * sign > 0.0 and v in taken.eibm_Nm]
        ratios = [found.mean_eibm(v) / taken.eibm_Nm[v] for v in own]
        return sum(ratios) / len(ratios) if ratios else 1.0

    up, down = dynamic.moment_per_volt_Nm
    return replace(
        dynamic,
        moment_per_volt_Nm=(up.scaled(factor(1.0), up.unit), down.scaled(factor(-1.0), down.unit)),
    )


def _marked(one: ActiveEffect, names: tuple[str, ...]) -> ActiveEffect:
    if one.name not in deviations():
        return one
    return replace(one, beside_dynamics=tuple(n for n in names if one.values(n) is not None))
