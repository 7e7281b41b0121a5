"""From a case to the measurements that a rig would have handed over, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.forms import Form
from benchmarks.hidden_effects.recipe import BOTH, Recipe, base_recipe, geometry
from benchmarks.hidden_effects.registry import CATALOGUE, form_of
from benchmarks.hidden_effects.truth import HiddenEffect, Truth
from benchmarks.hidden_effects.visits import FREE_TRAIN, POSITIONS_M, train_of, visits
from model import Condition, Curve, Measurements, Reading, TimeSeries
from sim_hardware.world import (
    CurveErrors,
    Scatter,
    TimedReading,
    TimedRun,
    Visit,
    WorldSettings,
    timed_session,
)

_OUTLIER_STREAM = 0xCE141


@dataclass(frozen=True)
class Hidden:
    """A session with something, or nothing, hidden in it."""

    case: Case
    measurements: Measurements
    truth: Truth


def hidden_session(case: Case, change: Callable[[Recipe], None] = lambda _: None) -> Hidden:
    """Measure. The same case gives the same data; `change` is made to its world, too."""
    recipe, effects = prepared(case)
    change(recipe)
    world = recipe.settings()
    planned = list(visits(case))
    outlier = _outlier(case, planned)
    if outlier is not None:
        planned[outlier] = _set_up_badly(planned[outlier], world, outlier)
    runs = timed_session(
        world,
        planned,
        train=train_of(case),
        free_train=FREE_TRAIN,
        errors=CurveErrors(),
        series_hz=case.series_hz,
    )
    truth = Truth(
        effects,
        case.seed,
        {name: world.configurations[name].stiffness_Nm2 for name in BOTH},
        {name: _mean_eibm(world, name) for name in BOTH},
        case.rest,
        outlier,
        tuple(run.scatter for run in runs),
    )
    return Hidden(case, _measured(case, recipe, runs), truth)


def prepared(case: Case) -> tuple[Recipe, tuple[HiddenEffect, ...]]:
    """The world with everything hidden in it."""
    recipe, effects = base_recipe(case), []
    for hiding in case.hidden:
        form = form_of(hiding.effect, hiding.form)
        if form.symmetric and not case.symmetric:
            raise ValueError(f"{form.effect} is only hidden where Case.symmetric is set")
        size = form.size if hiding.size is None else hiding.size
        if size != 0.0:
            form.change(recipe, size)
        effects.append(_described(form, size))
    return recipe, tuple(effects)


def _described(form: Form, size: float) -> HiddenEffect:
    return HiddenEffect(
        effect=form.effect,
        form=form.form,
        size=size,
        unit=form.unit,
        in_catalogue=form.effect in CATALOGUE,
        slot=form.slot,
        accepted_slots=(form.slot, *form.accepted),
        place_mm=form.place_mm,
        parameters=form.parameters(size) if size else {},
    )


def _mean_eibm(world: WorldSettings, name: str) -> dict[float, float]:
    sheet = world.configurations[name]
    s = (np.arange(2000) + 0.5) / 2000 * sheet.free_length_m
    mean = sheet.stiffness_Nm2 * float(np.mean(world.eibm_per_m(name, s)))
    return {volts: mean * world.eibm.settled(volts) for volts in (2.0, -2.0)}


# -------------------------------------------------------------------------------- an outlier


def _outlier(case: Case, planned: Sequence[Visit]) -> int | None:
    """Which run is set up badly: one of those of the long sheet, which comes first."""
    if not case.outlier:
        return None
    touching = [i for i, visit in enumerate(planned) if visit.position_m is not None]
    random = np.random.default_rng((case.seed, _OUTLIER_STREAM))
    return touching[int(random.integers(len(POSITIONS_M)))]


def _set_up_badly(visit: Visit, world: WorldSettings, number: int) -> Visit:
    """Not quite where it should be, and less moist than the others."""
    usual = Scatter.draw(world, number)
    odd = Scatter(
        eibm=usual.eibm * 0.93,
        stiffness=usual.stiffness * 1.05,
        position_m=usual.position_m + 0.6e-3,
    )
    return Visit(
        configuration=visit.configuration,
        position_m=visit.position_m,
        mounting=visit.mounting,
        approach=visit.approach,
        turn=visit.turn,
        odd=odd,
    )


# ------------------------------------------------------------------------------ the measurements


def _measured(case: Case, recipe: Recipe, runs: list[TimedRun]) -> Measurements:
    conditions = tuple(c for run in runs for c in _conditions(case, run))
    series: tuple[TimeSeries, ...] = ()
    if case.streams == "all":
        series = tuple(_series(run) for run in runs)
    return Measurements(
        sheets=geometry(recipe), conditions=conditions, series=series, source="forces.csv"
    )


def _conditions(case: Case, run: TimedRun) -> Iterator[Condition]:
    visit = run.visit
    for voltage, points in run.curves_m.items():
        readings = tuple(_reading(case, run, r) for r in run.readings if r.voltage_V == voltage)
        yield Condition(
            configuration=visit.configuration,
            position_m=visit.position_m,
            voltage_V=voltage,
            readings=readings,
            curve=None if visit.load_cell_alone else _curve(run.s_m, points, run.curve_sigma_m),
            mounting=visit.mounting,
            approach=visit.approach,
            tilt_rad=np.pi if visit.turned_over else 0.0,
            run=visit.turn,
        )


def _reading(case: Case, run: TimedRun, r: TimedReading) -> Reading:
    if case.streams == "means":
        return Reading(index=r.index, kind=r.kind, force_N=r.force_N)
    return Reading(
        index=r.index,
        kind=r.kind,
        force_N=r.force_N,
        time_s=r.time_s,
        session_s=run.start_s + r.time_s,
        wetted_s=run.wet_s + r.time_s,
        curve=_curve(run.s_m, r.curve_m, run.reading_sigma_m),
    )


def _curve(s_m: np.ndarray, points: np.ndarray, sigma_m: float) -> Curve:
    return Curve(s_m=s_m, x_m=points[:, 0], y_m=points[:, 1], sigma_m=np.full(len(s_m), sigma_m))


def _series(run: TimedRun) -> TimeSeries:
    visit = run.visit
    force = None if visit.position_m is None else run.force_N
    return TimeSeries(
        configuration=visit.configuration,
        position_m=visit.position_m,
        time_s=run.time_s,
        drive_V=run.drive_V,
        force_N=force,
        mounting=visit.mounting,
        run=visit.turn,
    )
