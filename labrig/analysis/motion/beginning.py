"""Where the identification of a moving sheet begins: usual values, scaled to what was recorded.

The force of a sheet in contact is B times a function of k0 and of the curvature per volt; a free
sheet swings as the square root of B over its mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from labrig.analysis.motion.noise import USUAL_CURVE_M
from labrig.analysis.motion.rest_shape import rest_curvature
from labrig.errors import BadArgumentError, BadInputError
from model.dynamics import DynamicBeam, ElectrodeLine, Elongation, Resolution, Viscoelasticity
from model.dynamics.dynamic_sheet import fluid_around
from model.dynamics.identification import RecordedRun
from model.dynamics.identification.predicted_run import predict
from model.measurements import FloatArray, ModelError, SheetGeometry
from model.mechanics.field import Field

USUAL_E_PA = 120e6
USUAL_DENSITY = 2300.0  # kg/m3, of the wet sheet with its electrodes
USUAL_CURVATURE_PER_V = 20.0  # 1/m, Me/B of a volt
USUAL_LOSS = Viscoelasticity(B_Nm2=1.0, shares=(0.1, 0.1), times_s=(0.03, 0.3), viscous_time_s=3e-4)
LEAST_SWING_M = 3e-4
SLOWEST_SWING_HZ, FASTEST_SWING_HZ = 0.3, 15.0
COARSE = Resolution(
    step_s=2e-3, after_edges=1, degrees=(6, 2), free_degrees=6, line_terms=12
)  # fmt: skip
FIRST_MODE = 1.8751040687119612
FORCE_EVERY = 5  # samples
ELONGATION_UNKNOWN = (
    "the sheet '{}' has an elongation whose mass no recording tells apart: state it with"
    " elongation_g_per_m."
)


@dataclass(frozen=True, kw_only=True)
class StatedValues:
    """What no recording tells: stated by the user."""

    fluid: str = "air"
    elongation_kg_per_m: float | None = None
    source_ohm: float = 1.0


def beginning(
    sheet: SheetGeometry, runs: Sequence[RecordedRun], stated: StatedValues
) -> DynamicBeam:
    """Return a sheet to begin with. Raises BadInputError, where something must be stated."""
    beam = _usual(sheet, stated)
    polarities = [volts for run in runs for volts in run.plan.drive.voltage_V.tolist()]
    beam = _with_curvature(beam, USUAL_CURVATURE_PER_V, polarities)
    beam = _with_rest(beam, sheet, runs)
    held = [run for run in runs if run.force_N is not None]
    try:
        beam = _scaled_to_force(beam, held) if held else beam
        beam = _with_rest(beam, sheet, runs)  # the amplifier's offset bends it
    except ModelError:
        pass  # a sheet that leaves the rolls with usual values: B stays usual
    return _with_mass(beam, [run for run in runs if run.plan.setup is None])


def _usual(sheet: SheetGeometry, stated: StatedValues) -> DynamicBeam:
    name = sheet.configuration
    if sheet.elongation_m > 0.0 and stated.elongation_kg_per_m is None:
        raise BadArgumentError(ELONGATION_UNKNOWN.format(name), "elongation_g_per_m")
    B = USUAL_E_PA * sheet.width_m * sheet.thickness_m**3 / 12.0
    fluid = fluid_around(stated.fluid, sheet.width_m)
    return DynamicBeam(
        length_m=sheet.free_length_m,
        mass_per_length_kg_per_m=USUAL_DENSITY * sheet.width_m * sheet.thickness_m,
        material=replace(USUAL_LOSS, B_Nm2=B),
        rest=_stated_rest(sheet),
        fluid=fluid,
        elongation=Elongation(
            length_m=sheet.elongation_m,
            mass_per_length_kg_per_m=stated.elongation_kg_per_m or 0.0,
            fluid=fluid,
        ),
        electrodes=ElectrodeLine(
            electrode_ohm_per_m=4000.0, capacitance_F_per_m=0.3, bulk_ohm_m=0.5,
            leak_S_per_m=0.1, source_ohm=stated.source_ohm,
        ),
    )  # fmt: skip


def _stated_rest(sheet: SheetGeometry) -> Field:
    if sheet.initial_curvature is None:
        return Field.constant(0.0, sheet.free_length_m)
    return Field.linear(*sheet.initial_curvature, sheet.free_length_m)


def _with_rest(beam: DynamicBeam, sheet: SheetGeometry, runs: Sequence[RecordedRun]) -> DynamicBeam:
    """Return the sheet with the shape that it was filmed in at rest."""
    stated = sheet.initial_curvature is not None
    found = rest_curvature(beam, runs, USUAL_CURVE_M, stated=stated)
    if found is not None:
        return replace(beam, rest=found.rest)
    if stated:
        return beam
    raise BadInputError(
        f"sheet.toml: [{sheet.configuration}] initial_curvature_per_m is to be measured, and no"
        " free sheet was filmed at rest: state it, or record [extras] release = true."
    )


def _with_curvature(
    beam: DynamicBeam, curvature_per_V: float, volts: Sequence[float]
) -> DynamicBeam:
    """Return the sheet with a moment per volt of each polarity; a charge may change its sign."""
    moment = beam.material.B_Nm2 * curvature_per_V
    return replace(beam, moment_per_volt_Nm=(moment, moment) if any(volts) else (0.0, 0.0))


def _scaled_to_force(beam: DynamicBeam, runs: Sequence[RecordedRun]) -> DynamicBeam:
    """Return the sheet whose force is nearest to the recorded one, F = B (f0 + alpha/B f1)."""
    alpha, B = beam.moment_per_volt_Nm, beam.material.B_Nm2
    still = replace(beam, moment_per_volt_Nm=(0.0, 0.0))
    columns, force = [], []
    for run in runs:
        if run.force_N is None:
            continue
        plan = replace(
            run.plan, current=False, frame_s=np.zeros(0), points_m=np.zeros(0),
            time_s=run.plan.time_s[::FORCE_EVERY],
        )  # fmt: skip
        at_rest, driven = (predict(one, plan, COARSE).force_N for one in (still, beam))
        columns.append(np.stack([at_rest, driven - at_rest], axis=1))
        force.append(run.force_N[::FORCE_EVERY])
    with_zero = np.concatenate(columns)
    stiffer, moved = np.linalg.lstsq(with_zero, np.concatenate(force), rcond=None)[0]
    if not (0.05 < stiffer < 20.0 and 0.05 < moved < 20.0):  # the zero is not known so well
        return beam
    return replace(
        beam,
        material=replace(beam.material, B_Nm2=float(B * stiffer)),
        moment_per_volt_Nm=(float(alpha[0] * moved), float(alpha[1] * moved)),
    )


def _with_mass(beam: DynamicBeam, free: Sequence[RecordedRun]) -> DynamicBeam:
    """Return the sheet with the mass that its swing after the last edge shows."""
    found = [hz for hz in map(swing_hz, free) if hz is not None]
    if not found or beam.elongation.length_m > 0.0:
        return beam
    omega = 2.0 * np.pi * float(np.median(found))
    whole = beam.material.B_Nm2 * (1.0 + 0.5 * sum(beam.material.shares))
    mass = whole * (FIRST_MODE / beam.length_m) ** 4 / omega**2
    mass -= beam.fluid.added_mass_kg_per_m
    return replace(beam, mass_per_length_kg_per_m=float(mass)) if mass > 0.0 else beam


def swing_hz(run: RecordedRun) -> float | None:
    """Return the frequency at which the free end swings; None where it does not."""
    if run.y_m is None or run.x_m is None:
        return None
    last = float(run.plan.drive.time_s[-1])
    after = (run.plan.frame_s > last + 0.1) & np.isfinite(run.y_m[:, -1])
    time_s, y_m = run.plan.frame_s[after], run.y_m[after, -1]
    if len(time_s) < 8:
        return None
    # beyond half the frame rate a faster swing looks like a slower one
    fastest = min(FASTEST_SWING_HZ, 0.45 / float(np.median(np.diff(time_s))))
    frequencies = np.geomspace(SLOWEST_SWING_HZ, max(fastest, 2.0 * SLOWEST_SWING_HZ), 300)
    cost = [_left(time_s, y_m, hz) for hz in frequencies]
    best = int(np.argmin(cost))
    swing = np.sqrt(max(0.0, _left(time_s, y_m, 0.0) - cost[best]) / len(time_s))
    return float(frequencies[best]) if swing > LEAST_SWING_M else None


def _left(time_s: FloatArray, y_m: FloatArray, hz: float) -> float:
    """Return the sum of squares beside a decaying swing and a creep."""
    fade = np.exp(-(time_s - time_s[0]))
    columns = [np.ones_like(time_s), fade]
    if hz:
        turn = 2.0 * np.pi * hz * time_s
        columns += [fade * np.cos(turn), fade * np.sin(turn)]
    matrix = np.stack(columns, axis=1)
    away = y_m - matrix @ np.linalg.lstsq(matrix, y_m, rcond=None)[0]
    return float(away @ away)
