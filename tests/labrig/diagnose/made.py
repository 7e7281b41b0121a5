"""Diagnoses made by hand from known sheets, as a procedure would hand them back."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from model import Along, Parameter, SheetModel, predict
from model.discrepancy.verdict.result import (
    BeforeAfter,
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
        eibm = {v: Along.constant(Parameter(one.mean_eibm(v), 0.0, "N m")) for v in one.eibm}
        sheets[name] = replace(one, eibm=eibm)
    return replace(model, sheets=sheets)


def named_effect() -> ActiveEffect:
    decay = Parameter(1e3 * DECAY_M, 0.4, "mm")
    return ActiveEffect("nonuniform_eibm", {"decay_length_mm": decay})


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
                "nonuniform_eibm", "eibm",
                {"decay_length_mm": Parameter(12.0, 0.4, "mm"),
                 "end_to_root_ratio": Parameter(0.016, 0.002, "")},
                {}, 0.993, (), 0.08,
                FormCurve("s", "mm", s, form, 1.02 * form, 0.05 * form, "of the EIBM"),
            ),
        ),
        invisible={"charging_lag": "the force over a whole pulse"},
        unknown=None,
        where=(
            Where("force", "long", 2.0, 0.0, None, 41.2),
            Where("curve", "long", 2.0, 0.0, 38.0, -22.7),
            Where("signal", "long", -2.0, 10.0, None, 5.1, "0.02 s after the edge"),
        ),
        fitted=BeforeAfter(Gap(0.41, 1.62, 900.0), Gap(0.03, 0.02, 1.1)),
        held_out=BeforeAfter(Gap(0.45, 1.71, 950.0), Gap(0.04, 0.03, 1.3)),
        closed=0.994,
        next_measurement=None,
        ranking=(
            Ranked("nonuniform_eibm", "eibm", 812.4, 2.5, 300.0),
            Ranked("load_cell_hysteresis", "load_cell", 310.0, 4.0, 60.0, "less likely"),
            Ranked("unknown:eibm", "eibm", 250.0, 0.3, 90.0, "a known effect does better"),
            Ranked("gravity", "even_moment", -1.8, 0.0, 12.0),
        ),
        threshold=6.2,
        threshold_from="the 95th percentile of 200 simulated sessions with nothing missing",
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
            name: {"B_Nm2": Parameter(B, 0.006e-6, "N m^2"),
                   "EIBM_Nm +2 V": Parameter(3.6e-5, 1e-7, "N m")}
            for name, B in STIFFNESS.items() if name in measurements.sheets
        },
    )  # fmt: skip


def _row(condition, base: SheetModel, model: SheetModel) -> ErrorRow:
    where = (condition.configuration, condition.position_m, condition.voltage_V)
    before, after = predict(base, *where), predict(model, *where)
    curve, empty = condition.curve, np.zeros(0)
    force = float(np.mean([r.force_N for r in condition.used()]))
    if curve is None:
        return ErrorRow(
            *where, force, SIGMA_N, before.F_N, after.F_N, empty, empty, empty, (empty, empty),
            (empty, empty), empty, empty,
        )  # fmt: skip

    def off(one):
        return (curve.y_m - one.y_m) * np.cos(np.gradient(one.y_m, one.s_m))

    return ErrorRow(
        *where, force, SIGMA_N, before.F_N, after.F_N, curve.s_m, curve.x_m, curve.y_m,
        (before.x_m, before.y_m), (after.x_m, after.y_m), off(before), off(after),
        before.F_N, after.F_N,
    )  # fmt: skip


def nothing_missing() -> Diagnosis:
    one = found()
    return replace(
        one, verdict="nothing_missing", effects=(), where=(), closed=float("nan"),
        sentence="Nothing is missing: the base model explains the data to within their noise.",
        fitted=BeforeAfter(one.fitted.after, one.fitted.after),
        held_out=BeforeAfter(one.held_out.after, one.held_out.after),
        model=one.model.with_effects(),
    )  # fmt: skip


def indistinguishable() -> Diagnosis:
    """Two names for the same: a class, and what would separate it."""
    one = found()
    first = replace(one.effects[0], confusable_with=("load_cell_hysteresis",), confidence=0.97)
    protocol = {
        "pulse_train": {"voltages_V": [2.0, -2.0]},
        "places": [{"configuration": "long", "positions_mm": [0.0, 15.0]}],
        "extras": {"free_shapes": True},
    }
    return replace(
        one, verdict="indistinguishable", effects=(first,),
        sentence="Either the EIBM falls along the sheet or the load cell hangs behind.",
        next_measurement=Next(
            "Six free shapes would tell nonuniform_eibm from load_cell_hysteresis.",
            "free_shapes", 1.8, 14.0, 2.0, protocol,
        ),
    )  # fmt: skip


def unknown() -> Diagnosis:
    one = found()
    s = np.linspace(0.0, 50.0, 51)
    bump = 0.2 * np.exp(-(((s - 30.0) / 6.0) ** 2))
    profile = Profile("s", tuple(1e-3 * s), tuple(bump), tuple(0.02 + 0.0 * s), "relative")
    term = ActiveEffect("unknown", profile=profile, location="eibm", configurations=("long",))
    return replace(
        one, verdict="unknown_effect", effects=(),
        sentence="Something that no effect of the catalogue explains acts on the EIBM.",
        unknown=Unknown(
            "eibm", "long", s, bump, 0.02 + 0.01 * bump, "relative", "s",
            "in proportion to the EIBM, so it changes sign with the voltage",
        ),
        model=one.model.with_effects(term),
    )  # fmt: skip


def cannot_tell() -> Diagnosis:
    return replace(
        nothing_missing(), verdict="cannot_tell",
        sentence="The scatter of the set-ups can be neither measured nor estimated: set three"
        " positions anew.",
    )  # fmt: skip


ALL = (found, nothing_missing, indistinguishable, unknown, cannot_tell)
