"""Predict the excess of a moving, charging sheet over the sheet at rest, reading by reading.

At rest means the base model: the relaxed stiffness B, and at each voltage one EIBM, the same along
the sheet. That EIBM is the mean over the sheet of what the electrodes' charge makes at the instants
of the readings.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.at_rest.runs import DrivenRun, at_s, frame_at_s
from model.dynamics import DynamicBeam, DynamicSheet, HeldVoltage, LineModes, Resolution, simulate
from model.dynamics.motion import SAME_TIME
from model.identification.data.data_vector import Index
from model.identification.data.pulses import STEP_V, WINDOW_S
from model.measurements import (
    Condition,
    Curve,
    FloatArray,
    Measurements,
    ModelError,
    Reading,
    SheetGeometry,
)
from model.parameter import Parameter
from model.sheet.configured_sheet import Along, ConfiguredSheet
from model.sheet.sheet_model import SheetModel
from model.sheet.solution import SolvedProblems, solved

WITHIN = np.linspace(-WINDOW_S, WINDOW_S, 9)  # of a reading: for the mean that its filter makes
CHARGE_NODES = 20  # for the mean of the charge along the sheet


@dataclass(frozen=True, kw_only=True)
class Scale:
    """The base model's parameters over those of the model file."""

    stiffness: float
    eibm: Mapping[float, float]  # Me/B by voltage

    def moment(self, sign: float) -> float:
        """Return the factor of the moment per volt of a polarity: what its voltages share.

        It is no factor of the drive: the charge that a pulse leaves to the next one stays as it is.
        """
        own = [factor for volts, factor in self.eibm.items() if volts * sign > 0.0]
        return sum(own) / len(own) if own else 1.0

    def driven(self, drive: HeldVoltage) -> HeldVoltage:
        """Return the drive that makes what the voltages of a polarity do not share."""
        known = np.array(sorted(self.eibm))
        if not len(known):
            return drive
        near = known[np.argmin(np.abs(drive.voltage_V[:, None] - known), axis=1)]
        factor = np.array([self.eibm[v] / self.moment(v) for v in near.tolist()])
        return HeldVoltage(drive.time_s, drive.voltage_V * factor)


@dataclass(frozen=True, kw_only=True)
class SheetInMotion:
    """One configuration in time, and the same at rest."""

    sheet: SheetGeometry
    dynamic: DynamicSheet
    B_Nm2: float  # of the model file
    rest: Along  # k0
    eibm_Nm: Mapping[float, float]  # at the instants of readings, of the file's B
    scale: Scale
    late_s: float = 0.0  # all edges of the drive
    farther_m: float = 0.0  # all contacts along the arc

    def beam(self) -> DynamicBeam:
        """Return it as it moves."""
        beam = self.dynamic.beam(self.sheet, self.B_Nm2, self.rest.field(self.sheet.free_length_m))
        more, (up, down) = self.scale.stiffness, beam.moment_per_volt_Nm
        material = replace(beam.material, B_Nm2=self.B_Nm2 * more)
        up, down = up * self.scale.moment(1.0), down * self.scale.moment(-1.0)
        return replace(beam, material=material, moment_per_volt_Nm=(more * up, more * down))

    def solved(self, position_m: float | None, volts: Sequence[float]) -> SolvedProblems:
        """Return its equilibria at these voltages. Raises ModelError where there is none."""
        stiffer = self.scale.stiffness
        eibm = {
            v: Along.constant(_exact(stiffer * self.scale.eibm.get(v, 1.0) * moment, "N m"))
            for v, moment in self.eibm_Nm.items()
        }
        B = _exact(stiffer * self.B_Nm2, "N m^2")
        name = self.sheet.configuration
        model = SheetModel(sheets={name: ConfiguredSheet(self.sheet, B, self.rest, eibm)})
        found = solved(model.setups(name, [(position_m, v) for v in volts]))
        if position_m is not None and not np.all(np.isfinite(found.force_N)):
            raise ModelError(
                f"the dynamic model of '{name}' has no equilibrium at {position_m * 1e3:g} mm"
            )
        return found


def _exact(value: float, unit: str) -> Parameter:
    return Parameter(value=value, sigma=0.0, unit=unit)


def charged_eibm_Nm(
    dynamic: DynamicSheet, sheet: SheetGeometry, runs: Sequence[DrivenRun], data: Measurements
) -> dict[float, float]:
    """Return the mean EIBM along the sheet at the readings that count, by voltage."""
    found: dict[float, list[float]] = {}
    held = [run for run in runs if run.position_m is not None] or list(runs)
    straight = Along.constant(_exact(0.0, "1/m")).field(sheet.free_length_m)
    beam = dynamic.beam(sheet, 1.0, straight)
    if beam.electrodes is None:
        return {}
    line = LineModes(beam.electrodes, beam.length_m, Resolution().line_terms)
    nodes, weights = np.polynomial.legendre.leggauss(CHARGE_NODES)
    along = line.at(0.5 * beam.length_m * (1.0 + nodes))
    up, down = beam.moment_per_volt_Nm
    for run in held:
        for place in run.conditions:
            condition = data.conditions[place]
            times = np.array([at_s(r) for r in counted(condition)])
            if not condition.voltage_V or not len(times):
                continue
            U = _charge(line, run.drive, times) @ along.T
            Me = np.where(U > 0.0, up, down) * U
            found.setdefault(condition.voltage_V, []).append(float(np.mean(Me @ weights) / 2.0))
    return {v: float(np.mean(each)) for v, each in found.items()}


def _charge(line: LineModes, drive: HeldVoltage, times_s: FloatArray) -> FloatArray:
    """Return the modes of the line at times that ascend, (n, T)."""
    edges = drive.time_s[drive.time_s < times_s[-1]]
    knots = np.unique(np.concatenate([edges, times_s]))
    held = drive.at(0.5 * (knots[1:] + knots[:-1]))
    modes = line.respond(np.zeros(line.terms), np.diff(knots), held)
    return modes[np.searchsorted(knots, times_s)]


def counted(condition: Condition) -> list[Reading]:
    """Return the readings that count in a condition, free shapes among them, in time order."""
    kinds = ("zero", "kept", "no_contact")
    return sorted((r for r in condition.readings if r.valid and r.kind in kinds), key=at_s)


# ------------------------------------------------------------------------------ one run


@dataclass(frozen=True, kw_only=True)
class RunExcess:
    """Of one run, in motion less at rest; places as in `DrivenRun`."""

    force_N: Mapping[int, FloatArray]  # by condition: of each reading
    curves: Mapping[int, CurveExcess]  # by condition
    series_N: Mapping[int, FloatArray]  # by series: of each sample

    def plus(self, other: RunExcess, sign: float = 1.0) -> RunExcess:
        """Return the sum of two of the same run."""
        return RunExcess(
            force_N={i: a + sign * other.force_N[i] for i, a in self.force_N.items()},
            curves={i: a.plus(other.curves[i], sign) for i, a in self.curves.items()},
            series_N={i: a + sign * other.series_N[i] for i, a in self.series_N.items()},
        )

    def less(self, other: RunExcess) -> RunExcess:
        """Return the difference of two of the same run."""
        return self.plus(other, -1.0)


@dataclass(frozen=True, kw_only=True)
class CurveExcess:
    """Of the curves of one condition's readings, on a grid along the sheet."""

    s_m: FloatArray  # (S,)
    x_m: FloatArray  # (readings, S)
    y_m: FloatArray
    curvature_per_m: FloatArray

    def plus(self, other: CurveExcess, sign: float) -> CurveExcess:
        """Return the sum of two on the same grid."""
        x, y, k = (
            getattr(self, name) + sign * getattr(other, name)
            for name in ("x_m", "y_m", "curvature_per_m")
        )
        return CurveExcess(s_m=self.s_m, x_m=x, y_m=y, curvature_per_m=k)

    def mean(self, which: Sequence[int]) -> CurveExcess:
        """Return the mean over some readings, as one."""
        rows = np.array(which, dtype=np.int64)
        mean = (np.mean(a[rows], axis=0)[None] for a in (self.x_m, self.y_m, self.curvature_per_m))
        x, y, k = mean
        return CurveExcess(s_m=self.s_m, x_m=x, y_m=y, curvature_per_m=k)

    def taken_off(self, curve: Curve, row: int) -> Curve:
        """Return a curve as it would be at rest."""
        dx, dy, dk = (
            np.interp(curve.s_m, self.s_m, a[row])
            for a in (self.x_m, self.y_m, self.curvature_per_m)
        )
        bent = curve.curvature_per_m
        return replace(
            curve, x_m=curve.x_m - dx, y_m=curve.y_m - dy,
            curvature_per_m=None if bent is None else bent - dk,
        )  # fmt: skip


def excess(
    moving: SheetInMotion, run: DrivenRun, data: Measurements, resolution: Resolution | None = None
) -> RunExcess:
    """Return what motion and charge add to everything that was measured in a run."""
    conditions = {i: data.conditions[i] for i in run.conditions}
    series = {i: data.series[i] for i in run.series if data.series[i].force_N is not None}
    times = _times(run, conditions.values(), [s.time_s for s in series.values()])
    s_m = _grid(moving.sheet)
    drive = moving.scale.driven(run.drive)
    drive = HeldVoltage(drive.time_s - run.begin_s + moving.late_s, drive.voltage_V)
    place_m = None if run.position_m is None else run.position_m + moving.farther_m
    beam, touches = moving.beam(), place_m is not None
    rolls = None if place_m is None else moving.dynamic.rolls(moving.sheet, place_m)
    motion = simulate(beam, rolls, drive, times - run.begin_s, s_m=s_m, resolution=resolution)
    if motion.slipped_s is not None:
        where = "" if place_m is None else f" at {place_m * 1e3:g} mm"
        raise ModelError(
            f"with the dynamic model of '{run.configuration}' the sheet slips out of the rolls"
            f"{where}"
        )
    volts = list(dict.fromkeys(c.voltage_V for c in conditions.values()))
    still = moving.solved(place_m, volts)
    shapes = still.shapes(s_m)

    def at(instants: FloatArray) -> FloatArray:
        return np.searchsorted(times, instants - SAME_TIME).clip(0, len(times) - 1)

    force, curves = {}, {}
    for i, one in conditions.items():
        k = volts.index(one.voltage_V)
        rows = at(np.array([frame_at_s(r) for r in one.readings]))
        curves[i] = CurveExcess(
            s_m=s_m, x_m=motion.x_m[rows] - shapes.x_m[k], y_m=motion.y_m[rows] - shapes.y_m[k],
            curvature_per_m=motion.curvature_per_m[rows] - shapes.curvature_per_m[k],
        )  # fmt: skip
        if touches:
            windows = at(np.array([at_s(r) + WITHIN for r in one.readings]).ravel())
            read = motion.reading_N[windows].reshape(len(one.readings), -1).mean(axis=1)
            force[i] = read - still.force_N[k]
    series_N = {}
    for i, each in series.items():
        held = still.force_N[_levels(np.asarray(each.drive_V), np.array(volts))]
        series_N[i] = motion.reading_N[at(each.time_s)] - held
    return RunExcess(force_N=force, curves=curves, series_N=series_N)


def _levels(drive_V: FloatArray, volts: FloatArray) -> Index:
    """Return which of the voltages is held at each sample; one across an edge ends a pulse."""
    distance_V = np.abs(drive_V[:, None] - volts)
    sure = np.where(distance_V.min(axis=1) < STEP_V, np.arange(len(drive_V)), 0)
    return np.asarray(np.argmin(distance_V, axis=1)[np.maximum.accumulate(sure)])


def _times(
    run: DrivenRun, conditions: Iterable[Condition], sampled: Sequence[FloatArray]
) -> FloatArray:
    """Return all instants at which something of a run was measured, ascending."""
    readings = [r for c in conditions for r in c.readings]
    frames = np.array([frame_at_s(r) for r in readings])
    windows = [] if run.position_m is None else [np.array([at_s(r) + WITHIN for r in readings])]
    every = np.unique(np.concatenate([frames, *(w.ravel() for w in windows), *sampled]))
    every = every[every >= run.begin_s]
    return every[np.diff(every, prepend=-np.inf) > SAME_TIME]


def _grid(sheet: SheetGeometry) -> FloatArray:
    """Return places along sheet and elongation, close enough for straight lines between."""
    length, whole = sheet.free_length_m, sheet.free_length_m + sheet.elongation_m
    inner = np.linspace(0.0, length, 41)
    return inner if whole == length else np.append(inner, whole)
