"""Diagnoses made by hand from known sheets, as a procedure would hand them back."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from model import Along, Parameter, SheetModel, predict
from model.discrepancy.verdict.result import (
    BeforeAfter,
    ClosedGap,
    Diagnosis,
    ErrorRow,
    FormCurve,
    Gap,
    Named,
    Next,
    Ranked,
    Signatures,
    Unknown,
    Where,
)
from model.sheet.beam_problem import ActiveEffect, Profile
from tests.labrig.report_data import DECAY_M, STIFFNESS, measure, truth

SIGMA_N = 3e-5
NAMES = (
    "nonuniform_eibm",
    "load_cell_hysteresis",
    "clamp_compliance",
    "initial_curvature",
    "gravity",
)


def constant(model: SheetModel) -> SheetModel:
    """The same sheets with the mean of their EIBM all along."""
    sheets = {}
    for name, one in model.sheets.items():
        eibm = {
            v: Along.constant(Parameter(value=one.mean_eibm(v), sigma=0.0, unit="N m"))
            for v in one.eibm
        }
        sheets[name] = replace(one, eibm=eibm)
    return replace(model, sheets=sheets)


def named_effect() -> ActiveEffect:
    decay = Parameter(value=1e3 * DECAY_M, sigma=0.4, unit="mm")
    return ActiveEffect(name="nonuniform_eibm", parameters={"decay_length_mm": decay})


@cache
def found() -> Diagnosis:
    """The EIBM that falls along the sheet, named."""
    measurements = measure()
    base = constant(truth(*measurements.sheets))
    model = replace(
        base.with_effects(named_effect()), source=measurements.source,
        checksum=measurements.checksum,
    )  # fmt: skip
    rows = tuple(_row(c, base, model) for c in measurements.conditions if c.position_m is not None)
    s = np.linspace(0.0, 50.0, 14)
    form = np.exp(-s / 12.0)
    n = len(NAMES)
    cosine = np.eye(n) + 0.3 * (1.0 - np.eye(n))
    cosine[0, 1] = cosine[1, 0] = 0.93
    return Diagnosis(
        verdict="effect_named",
        sentence="The EIBM falls along the sheet: to 1/e within 12.0 ± 0.4 mm.",
        effects=(
            Named(
                name="nonuniform_eibm",
                location="eibm",
                parameters={
                    "decay_length_mm": Parameter(value=12.0, sigma=0.4, unit="mm"),
                    "end_to_root_ratio": Parameter(value=0.016, sigma=0.002, unit=""),
                },
                by_configuration={},
                confidence=0.993,
                confusable_with=(),
                form_share=0.08,
                form=FormCurve(
                    along="s",
                    unit="mm",
                    at=s,
                    catalogue=form,
                    inferred=1.02 * form,
                    band=0.05 * form,
                    what="of the EIBM",
                ),
            ),
        ),
        invisible={"charging_lag": "the force over a whole pulse"},
        unknown=None,
        where=(
            Where(
                observable="force",
                configuration="long",
                voltage_V=2.0,
                position_mm=0.0,
                s_mm=None,
                z=41.2,
            ),
            Where(
                observable="curve",
                configuration="long",
                voltage_V=2.0,
                position_mm=0.0,
                s_mm=38.0,
                z=-22.7,
            ),
            Where(
                observable="signal",
                configuration="long",
                voltage_V=-2.0,
                position_mm=10.0,
                s_mm=None,
                z=5.1,
                detail="0.02 s after the edge",
            ),
        ),
        fitted=BeforeAfter(
            Gap(force_rmse_mN=0.41, curve_rmse_mm=1.62, chi2_per_dof=900.0),
            Gap(force_rmse_mN=0.03, curve_rmse_mm=0.02, chi2_per_dof=1.1),
        ),
        held_out=BeforeAfter(
            Gap(force_rmse_mN=0.45, curve_rmse_mm=1.71, chi2_per_dof=950.0),
            Gap(force_rmse_mN=0.04, curve_rmse_mm=0.03, chi2_per_dof=1.3),
        ),
        closed=0.994,
        closed_gap=ClosedGap(
            share=0.994, quantity="force", before=0.45, after=0.04, floor=0.028, unit="mN"
        ),
        floor=Gap(force_rmse_mN=0.028, curve_rmse_mm=0.02, chi2_per_dof=1.0),
        next_measurement=None,
        ranking=(
            Ranked(
                name="nonuniform_eibm",
                location="eibm",
                log_bayes=812.4,
                size=2.5,
                detectability=300.0,
            ),
            Ranked(
                name="load_cell_hysteresis",
                location="load_cell",
                log_bayes=310.0,
                size=4.0,
                detectability=60.0,
                why_not="less likely",
            ),
            Ranked(
                name="unknown:eibm",
                location="eibm",
                log_bayes=250.0,
                size=0.3,
                detectability=90.0,
                why_not="a known effect does better",
            ),
            Ranked(
                name="gravity", location="even_moment", log_bayes=-1.8, size=0.0, detectability=12.0
            ),
        ),
        threshold=6.2,
        threshold_from="the 95th percentile of 200 simulated sessions of the base model",
        signatures=Signatures(
            NAMES, np.array([300.0, 60.0, 40.0, 55.0, 2.0]), 30 * (1 - np.eye(n)), cosine
        ),
        classes=(("force_offset", "gravity"),),
        rows=rows,
        scatter={"position": 5e-5, "eibm": 0.01, "stiffness": 0.012},
        outliers=(),
        notes=("The scatter of the set-ups was estimated from 24 conditions.",),
        model=model,
        seconds=3.4,
        base={
            name: {
                "B_Nm2": Parameter(value=B, sigma=0.006e-6, unit="N m^2"),
                "EIBM_Nm +2 V": Parameter(value=3.6e-5, sigma=1e-7, unit="N m"),
            }
            for name, B in STIFFNESS.items()
            if name in measurements.sheets
        },
    )


def _row(condition, base: SheetModel, model: SheetModel) -> ErrorRow:
    where = (condition.configuration, condition.position_m, condition.voltage_V)
    before, after = predict(base, *where), predict(model, *where)
    curve, empty = condition.curve, np.zeros(0)
    force = float(np.mean([r.force_N for r in condition.used()]))
    known = {
        "configuration": condition.configuration, "position_m": condition.position_m,
        "voltage_V": condition.voltage_V, "force_N": force, "sigma_N": SIGMA_N,
        "before_N": before.F_N, "after_N": after.F_N,
    }  # fmt: skip
    if curve is None:
        return ErrorRow(
            **known, s_m=empty, x_m=empty, y_m=empty, before_xy_m=(empty, empty),
            after_xy_m=(empty, empty), before_off_m=empty, after_off_m=empty,
        )  # fmt: skip

    def off(one):
        return (curve.y_m - one.y_m) * np.cos(np.gradient(one.y_m, one.s_m))

    return ErrorRow(
        **known, s_m=curve.s_m, x_m=curve.x_m, y_m=curve.y_m,
        before_xy_m=(before.x_m, before.y_m), after_xy_m=(after.x_m, after.y_m),
        before_off_m=off(before), after_off_m=off(after), held_out_before_N=before.F_N,
        held_out_after_N=after.F_N,
    )  # fmt: skip


def nothing_missing() -> Diagnosis:
    one = found()
    return replace(
        one, verdict="nothing_missing", effects=(), where=(), closed=float("nan"),
        closed_gap=None,
        sentence="Nothing is seen that is not in the model: what is left is noise and scatter.",
        fitted=BeforeAfter(one.fitted.after, one.fitted.after),
        held_out=BeforeAfter(one.held_out.after, one.held_out.after),
        model=one.model.with_effects(),
    )  # fmt: skip


def indistinguishable() -> Diagnosis:
    """Two names for the same: a class, and what would separate it."""
    one = found()
    first = replace(one.effects[0], confusable_with=("load_cell_hysteresis",), confidence=0.97,
        probabilities={"nonuniform_eibm": 0.62, "load_cell_hysteresis": 0.35},
    )  # fmt: skip
    protocol = {"extras": {"free_shapes": 6}}  # as the menu has it
    return replace(
        one, verdict="indistinguishable", effects=(first,),
        sentence="Either the EIBM falls along the sheet or the load cell hangs behind.",
        next_measurement=Next(
            why="Six free shapes would tell nonuniform_eibm from load_cell_hysteresis.",
            extra="free_shapes", separation=1.8, expected=14.0, minutes=2.0, protocol=protocol,
            between=("nonuniform_eibm", "load_cell_hysteresis"),
        ),
    )  # fmt: skip


def inseparable() -> Diagnosis:
    """The same, and nothing on the menu would separate them."""
    return replace(indistinguishable(), next_measurement=None)


def unknown() -> Diagnosis:
    one = found()
    s = np.linspace(0.0, 50.0, 51)
    bump = 0.2 * np.exp(-(((s - 30.0) / 6.0) ** 2))
    profile = Profile(
        along="s",
        at=tuple(1e-3 * s),
        values=tuple(bump),
        sigma=tuple(0.02 + 0.0 * s),
        unit="relative",
    )
    term = ActiveEffect(name="unknown", profile=profile, location="eibm", configurations=("long",))
    return replace(
        one,
        verdict="unknown_effect",
        effects=(),
        sentence="Something that no effect of the catalogue explains acts on the EIBM.",
        unknown=Unknown(
            location="eibm",
            configuration="long",
            s_mm=s,
            profile=bump,
            band=0.02 + 0.01 * bump,
            unit="relative",
            along="s",
            depends="in proportion to the EIBM, so it changes sign with the voltage",
        ),
        model=one.model.with_effects(term),
    )


def cannot_tell() -> Diagnosis:
    return replace(
        nothing_missing(), verdict="cannot_tell",
        sentence="The scatter of the set-ups can be neither measured nor estimated: set three"
        " positions anew.",
    )  # fmt: skip


ALL = (found, nothing_missing, indistinguishable, unknown, cannot_tell)
