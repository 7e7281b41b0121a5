"""labrig's own two models, at rest and in time, asked as the others are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from labrig.analysis.features.probe import ProbedModel
from labrig.analysis.motion.beginning import COARSE
from model import Along, ConfiguredSheet, Parameter, SheetModel
from model.dynamics import ContactSetup, DynamicBeam, ElectrodeLine, HeldVoltage, Viscoelasticity
from model.dynamics.beam import NO_ELONGATION, Elongation
from model.dynamics.fluid import fluid_load
from model.dynamics.identification import RunPlan
from model.dynamics.identification.predicted_run import predict
from model.dynamics.models import DrivenSheet, Response
from model.measurements import FloatArray
from model.sheet.prediction import predict_free

B_NM2 = 1.27e-6  # about the paper's long sheet
PLACES = 41
_MOMENT_PER_M = 50.0  # Me/B at the clamp at 1 V
_DECAY_M = 0.012


def labrigs_models() -> Mapping[str, ProbedModel]:
    """Return them by name."""
    return {
        "at rest": ProbedModel("labrig at rest, as in the paper", _at_rest),
        "in time": ProbedModel("labrig in time", _in_time),
    }


def _at_rest(run: DrivenSheet) -> Response:
    model, used = _resting_sheet(run), np.unique(run.drive_V)
    which = np.searchsorted(used, run.drive_V)
    if run.free:
        shapes = [predict_free(model, "sheet", volts) for volts in used.tolist()]
        x, y = (np.stack([shape[i] for shape in shapes]) for i in (1, 2))
        return Response(tip_m=y[which, -1], curves_m=(x[which], y[which]))
    found = model.predict("sheet", np.full(len(used), run.position_m or 0.0), used)
    return Response(
        force_N=found.F_N[which], tip_m=found.y_m[which, -1],
        curves_m=(found.x_m[which], found.y_m[which]),
    )  # fmt: skip


def _resting_sheet(run: DrivenSheet) -> SheetModel:
    length = run.sheet.free_length_m
    s_m = np.linspace(0.0, length, PLACES)
    moment = B_NM2 * _MOMENT_PER_M * np.exp(-s_m / _DECAY_M)
    eibm = {
        volts: Along(s_m, volts * moment, np.zeros(PLACES), "N m")
        for volts in np.unique(run.drive_V).tolist() if volts
    }  # fmt: skip
    stiffness = Parameter(value=B_NM2, sigma=0.0, unit="N m^2")
    rest = Along(s_m, run.rest(s_m), np.zeros(PLACES), "1/m")
    return SheetModel(sheets={"sheet": ConfiguredSheet(run.sheet, stiffness, rest, eibm)})


def _in_time(run: DrivenSheet) -> Response:
    sheet, times = run.sheet, run.time_s[run.frames]
    setup = None
    if run.position_m is not None:
        setup = ContactSetup(
            radius_m=sheet.arc_radius_m, origin_rad=sheet.arc_origin_rad, position_m=run.position_m
        )
    plan = RunPlan(
        drive=HeldVoltage(run.time_s, run.drive_V), time_s=run.time_s, setup=setup,
        force=setup is not None, frame_s=times,
        points_m=np.linspace(0.0, sheet.free_length_m, PLACES),
    )  # fmt: skip
    said = predict(_moving_sheet(run), plan, COARSE)
    y: FloatArray = said.y_m
    return Response(
        force_N=said.force_N if plan.force else None, current_A=said.current_A,
        tip_m=y[:, -1] if len(times) == len(run.time_s) else None, curves_m=(said.x_m, y),
    )  # fmt: skip


def _moving_sheet(run: DrivenSheet) -> DynamicBeam:
    sheet = run.sheet
    elongation = NO_ELONGATION
    if sheet.elongation_m:
        elongation = Elongation(length_m=sheet.elongation_m, mass_per_length_kg_per_m=2e-3)
    return DynamicBeam(
        length_m=sheet.free_length_m, mass_per_length_kg_per_m=5.8e-3,
        material=Viscoelasticity(
            B_Nm2=B_NM2, shares=(0.15, 0.1), times_s=(0.02, 0.3), viscous_time_s=0.2e-3
        ),
        rest=run.rest,
        fluid=fluid_load(sheet.width_m, 1.2, 1.82e-5, 3.3, drag_coefficient=2.0),
        elongation=elongation,
        electrodes=ElectrodeLine(
            electrode_ohm_per_m=4000.0, capacitance_F_per_m=0.3, bulk_ohm_m=0.5,
            leak_S_per_m=0.1, source_ohm=1.0,
        ),
        moment_per_volt_Nm=(30.0 * B_NM2, 30.0 * B_NM2),
    )  # fmt: skip
