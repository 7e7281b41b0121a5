"""Reduce measurements to a sheet at rest, by subtracting the predicted motion at each instant.

A static model compared with them sees what the dynamics do not explain. What they say goes with
stiffness and EIBM, which the fit finds, and is as unsure as the other parameters: the same is done
for each of them a step beside.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.at_rest.excess import (
    RunExcess,
    Scale,
    SheetInMotion,
    charged_eibm_Nm,
    counted,
    excess,
)
from model.discrepancy.at_rest.runs import DrivenRun, driven_runs
from model.discrepancy.at_rest.taken import DynamicsTaken
from model.discrepancy.at_rest.varied import Step, Varied, unsure
from model.dynamics import Resolution
from model.effects.catalogue import catalogue
from model.measurements import Condition, Measurements, ModelError, TimeSeries
from model.sheet.configured_sheet import Along
from model.sheet.sheet_model import SheetModel

STEP = 0.05  # relative, of stiffness and EIBM
FARTHER_M = 5e-4  # of all contacts along the arc
EDGE_S = 1e-3  # how well the edges' times are known against those of frames and readings
COARSE = Resolution(step_s=2.5e-3, after_edges=1, degrees=(6, 2), free_degrees=8)
INSTANT_S = 1e-6  # in which the EIBM of the corrected data follows the voltage


@dataclass(frozen=True, kw_only=True)
class AtRest:
    """The corrected measurements."""

    measurements: Measurements
    dynamics: Mapping[str, DynamicsTaken]  # by configuration
    varied: tuple[Varied, ...] = ()  # the same less other dynamics

    def of(self, kept: Measurements) -> AtRest:
        """Return the same of what was kept of the measurements: fewer conditions and readings."""
        own = {_key(c): c for c in kept.conditions}

        def like(data: Measurements) -> Measurements:
            found = (_like(c, own[_key(c)]) for c in data.conditions if _key(c) in own)
            return replace(data, conditions=tuple(found))

        others = tuple(Varied(one.step, like(one.measurements)) for one in self.varied)
        return replace(self, measurements=kept, varied=others)


def _key(one: Condition) -> tuple[object, ...]:
    """Return what tells a condition from all others."""
    return (
        one.configuration, one.position_m, one.voltage_V, one.mounting, one.run, one.tilt_rad,
        one.approach, one.session,
    )  # fmt: skip


def _like(one: Condition, kept: Condition) -> Condition:
    """Return a condition in which the same readings count."""
    pairs = zip(one.readings, kept.readings, strict=True)
    readings = (
        replace(r, valid=k.valid, why=k.why, curve=None if k.curve is None else r.curve)
        for r, k in pairs
    )
    return replace(one, readings=tuple(readings))


def at_rest(measurements: Measurements, model: SheetModel) -> AtRest:
    """Return measurements without what the dynamics of a model explain of them.

    Configurations of which the model has no dynamics stay as they are. Raises ModelError where the
    dynamics have no answer.
    """
    taken: dict[str, DynamicsTaken] = {}
    others: list[_Other] = []
    corrected, sheets = measurements, dict(measurements.sheets)
    for name in model.dynamic:
        if any(c.configuration == name and c.readings for c in measurements.conditions):
            change, taken[name], own = _of_one(measurements, model, name)
            corrected, others = change.applied(corrected), others + own
            # the rise at the sheet is in the dynamics
            sheets[name] = replace(sheets[name], rise_time_s=INSTANT_S)
    corrected = replace(corrected, sheets=sheets)
    return AtRest(
        measurements=corrected, dynamics=taken,
        varied=tuple(Varied(o.how, o.change.applied(corrected)) for o in others),
    )  # fmt: skip


def refuse_copies(model: SheetModel) -> None:
    """Raise a `ModelError` where effects of a model say again what its dynamics say."""
    for one in model.effects:
        known = catalogue().get(one.name)
        if known is None or not known.explained_by_dynamics:
            continue
        for name in model.sheets:
            if one.values(name) is None:
                continue
            if name in model.dynamic and name not in one.beside_dynamics:
                raise ModelError(
                    f"the model has the effect '{one.name}' and a table 'dynamic' of '{name}',"
                    " which describe the same: remove one of them"
                )
            if name in one.beside_dynamics and name not in model.dynamic:
                raise ModelError(
                    f"the effect '{one.name}' of the model was found beside dynamics of '{name}',"
                    " which it lacks: its table 'dynamic' is missing"
                )


@dataclass(frozen=True)
class _Changed:
    """Conditions and series of one configuration less what dynamics explain, by place."""

    conditions: Mapping[int, Condition]
    series: Mapping[int, TimeSeries]

    def applied(self, measurements: Measurements) -> Measurements:
        conditions, series = list(measurements.conditions), list(measurements.series)
        for i, condition in self.conditions.items():
            conditions[i] = condition
        for i, one in self.series.items():
            series[i] = one
        return replace(measurements, conditions=tuple(conditions), series=tuple(series))


@dataclass(frozen=True)
class _Other:
    how: Step
    change: _Changed


def _of_one(
    measurements: Measurements, model: SheetModel, name: str
) -> tuple[_Changed, DynamicsTaken, list[_Other]]:
    sheet, one, dynamic = measurements.sheets[name], model.sheet(name), model.dynamic[name]
    runs = list(driven_runs(measurements, name))
    stated = sheet.initial_curvature
    rest = one.rest if stated is None else Along(*stated, np.zeros(len(stated[0])), "1/m")
    eibm = charged_eibm_Nm(dynamic, sheet, runs, measurements)
    if 0.0 in eibm.values():
        raise ModelError(f"the dynamic model of '{name}' makes no EIBM at a voltage of these data")
    moving = SheetInMotion(
        sheet=sheet, dynamic=dynamic, B_Nm2=one.B.value, rest=rest, eibm_Nm=eibm,
        scale=Scale(stiffness=1.0, eibm={}),
    )  # fmt: skip
    found = [(run, excess(moving, run, measurements)) for run in runs]
    change = _changed(measurements, found)
    # how much differs with other dynamics is told as well with longer steps
    coarse = [(run, excess(moving, run, measurements, COARSE)) for run in runs]
    others = []
    for how, other in _others(moving):
        more = [
            (run, fine.plus(excess(other, run, measurements, COARSE)).less(was))
            for (run, fine), (_, was) in zip(found, coarse, strict=True)
        ]
        others.append(_Other(how, _changed(measurements, more)))
    return change, _taken(measurements, found, eibm), others


def _others(moving: SheetInMotion) -> Iterator[tuple[Step, SheetInMotion]]:
    """Yield sheets that differ in one parameter, and in which."""
    name, B = moving.sheet.configuration, moving.B_Nm2
    none = Step(configuration=name, of="unsure")
    stiffer = Scale(stiffness=1.0 + STEP, eibm={})
    yield (
        replace(none, of="stiffness", value=B, size=float(np.log1p(STEP))),
        replace(moving, scale=stiffer),
    )
    for volts, eibm in moving.eibm_Nm.items():
        more = Scale(stiffness=1.0, eibm={v: 1.0 + STEP * (v == volts) for v in moving.eibm_Nm})
        how = replace(none, of="eibm", value=eibm / B, size=STEP, voltage_V=volts)
        yield how, replace(moving, scale=more)
    yield replace(none, of="place", size=FARTHER_M), replace(moving, farther_m=FARTHER_M)
    yield none, replace(moving, late_s=EDGE_S)
    for dynamic in unsure(moving.dynamic):
        yield none, replace(moving, dynamic=dynamic)


def _changed(measurements: Measurements, found: list[tuple[DrivenRun, RunExcess]]) -> _Changed:
    """Return everything that was measured in runs, less what is found of them."""
    conditions, series = dict[int, Condition](), dict[int, TimeSeries]()
    for run, more in found:
        for i in run.conditions:
            conditions[i] = _condition(measurements.conditions[i], i, more)
        for i, force_N in more.series_N.items():
            measured = measurements.series[i].force_N
            if measured is not None:
                series[i] = replace(measurements.series[i], force_N=measured - force_N)
    return _Changed(conditions, series)


def _condition(one: Condition, place: int, more: RunExcess) -> Condition:
    """Return one condition as it would be at rest."""
    curves, force = more.curves[place], more.force_N.get(place)
    readings = tuple(
        replace(
            r,
            force_N=r.force_N if force is None or r.kind == "no_contact" else r.force_N - force[j],
            curve=None if r.curve is None else curves.taken_off(r.curve, j),
        )
        for j, r in enumerate(one.readings)
    )
    use = {id(r) for r in counted(one)}
    which = [j for j, r in enumerate(one.readings) if id(r) in use]
    curve = one.curve
    if curve is not None and which:
        curve = curves.mean(which).taken_off(curve, 0)
    return replace(one, readings=readings, curve=curve)


def _taken(
    measurements: Measurements, found: list[tuple[DrivenRun, RunExcess]], eibm: dict[float, float]
) -> DynamicsTaken:
    force, held, free = list[float](), list[float](), list[float]()
    for run, more in found:
        for i in run.conditions:
            condition = measurements.conditions[i]
            force += [] if i not in more.force_N else more.force_N[i].tolist()
            ends = np.hypot(more.curves[i].x_m[:, -1], more.curves[i].y_m[:, -1]).tolist()
            if condition.curve is not None or any(r.curve is not None for r in condition.readings):
                (free if run.position_m is None else held).extend(ends)
    return DynamicsTaken(force_N=_rms(force), curve_m=_rms(held), free_m=_rms(free), eibm_Nm=eibm)


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values else float("nan")
