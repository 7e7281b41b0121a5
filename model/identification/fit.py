"""`fit`: from measurements to a `Fit`, which holds the sheet's model."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from model.identification.along_runs import eibm_along_runs
from model.identification.base_model import not_weighed, weighs
from model.identification.data.outlier_readings import without_outliers
from model.identification.data.swinging_shapes import without_swinging
from model.identification.data.zero_voltage import offset_note
from model.identification.fit_result import ConfigurationFit, Fit
from model.identification.joint import Joint, joint_fit
from model.identification.joint_deviations import deviations
from model.identification.observations import Observed, not_driven, observe
from model.identification.options import FitOptions
from model.identification.paper import PaperFit, identify
from model.identification.residuals import ConditionResidual, Kind, Rmse, residuals, rmse
from model.measurements import Measurements, ModelError, in_decimals, in_volts, rms
from model.sheet import misfit
from model.sheet.configured_sheet import Along, ConfiguredSheet, FittedPositions
from model.sheet.deviations import Deviations
from model.sheet.sheet_model import SheetModel

NODES = 51  # of a quantity along the sheet, as handed on
BY_NOISE = 2.0  # standard uncertainties from which on a difference of curvatures is said
IN_WORDS = {"constant": "a constant EIBM", "varying": "the EIBM along the sheet"}
UNSETTLED = 0.02  # relative scatter of single readings' EIBM from which on it is said
POOR = 0.25  # relative uncertainty from which on a parameter is said not to be fixed
MOST_SCATTER = 0.5  # of stiffness or EIBM, from set-up to set-up; that of usual ones is 0.01


def fit(measurements: Measurements, options: FitOptions | None = None) -> Fit:
    """Identify every configuration; `ModelError` names the missing data."""
    options = options or FitOptions()
    cleaned = without_outliers(measurements)
    measurements, swinging = without_swinging(cleaned.measurements, where_touched=True)
    used, held_out = _without(measurements, options)
    names = options.configurations or tuple(
        n for n in used.sheets if any(c.configuration == n for c in used.conditions)
    )
    if not names and held_out:
        raise ModelError("every condition is held out, so there is nothing to fit; hold out fewer")
    if not names:
        raise ModelError(
            "there are no measurements: no condition of any configuration of the sheet"
        )
    observed = [observe(used, name) for name in names]
    for one in observed:
        if not one.voltages_V:
            why = not_driven(measurements, one.sheet.configuration)
            raise ModelError(f"{why}, or leave it out with --configuration")
    joint = joint_fit(used, observed, options)
    parts = {o.sheet.configuration: _Part(joint, n, o, options) for n, o in enumerate(observed)}
    ratio = _bootstrap(joint, options)
    ends = {name: FittedPositions.of(part.positions()) for name, part in parts.items()}
    fitted = {name: one for name, one in ends.items() if one is not None}
    models = [
        SheetModel(
            sheets={name: part.sheet(varying) for name, part in parts.items()},
            source=measurements.source, checksum=measurements.checksum, held_out=held_out,
            deviations=_deviations(joint) if varying else {}, fitted=fitted,
        )
        for varying in (False, True)
    ]  # fmt: skip
    rows = residuals(observed, models[0], models[1])
    errors: dict[Kind, Rmse] = {
        "constant": rmse(rows, "constant"), "varying": rmse(rows, "varying")
    }  # fmt: skip
    configurations = {name: part.table(rows) for name, part in parts.items()}
    done = []
    kinds: tuple[Kind, ...] = ("constant", "varying")
    for model, kind in zip(models, kinds, strict=True):
        own = {
            name: _merit(one.rmse, kind, [r for r in rows if r.configuration == name])
            for name, one in configurations.items()
        }
        done.append(replace(model, merit=_merit(errors, kind, rows), own_merit=own))
    notes = (
        *cleaned.sentences(),
        *swinging,
        *_notes(measurements, parts, configurations, rows, ratio),
        *_missed(done[1]),
    )
    return Fit(
        model=done[0], varying_model=done[1], configurations=configurations, residuals=rows,
        rmse=errors, scatter=joint.scatter(), noise=joint.noise(), bootstrap_ratio=ratio,
        notes=notes, options=options, joint=joint,
    )  # fmt: skip


def _deviations(joint: Joint) -> dict[str, Deviations]:
    """Return those of each configuration of which forces were measured."""
    data_vectors = zip(joint.forward.names, joint.forward.data_vectors, strict=True)
    return {name: deviations(joint, n) for n, (name, one) in enumerate(data_vectors) if weighs(one)}


def _merit(
    errors: Mapping[Kind, Rmse], kind: Kind, rows: Sequence[ConditionResidual]
) -> dict[str, float]:
    """Return the errors as a model file states them: those that exist.

    Beside those with constant EIBM stand those that the EIBM along the sheet would leave.
    """
    force_N = np.array([row.force_N for row in rows])
    force_N = force_N[np.isfinite(force_N)]
    merit = {misfit.FORCE: errors[kind].force_N, misfit.CURVE: errors[kind].curve_m}
    merit[misfit.FORCE_SIZE] = float(np.sqrt(np.mean(force_N**2))) if len(force_N) else np.nan
    if kind == "constant":
        along = errors["varying"]
        merit |= {misfit.ALONG_FORCE: along.force_N, misfit.ALONG_CURVE: along.curve_m}
    return {name: value for name, value in merit.items() if np.isfinite(value)}


class _Part:
    """One configuration while its results are put together."""

    def __init__(self, joint: Joint, n: int, observed: Observed, options: FitOptions) -> None:
        self.joint, self.n, self.observed = joint, n, observed
        configuration_model = joint.forward.configuration_models[n]
        self.name, self.length = observed.sheet.configuration, configuration_model.length
        self.B = joint.stiffness(n)
        self.voltages = observed.voltages_V
        self.eibm = {v: joint.constant_eibm(n, v) for v in self.voltages}
        self.s_m = np.linspace(0.0, self.length, NODES)
        self.along = {v: joint.along(n, v, self.s_m) for v in self.voltages}
        self.known = joint.rest_known[n]
        self.measured = joint.rest(n)(self.s_m)
        self.rest = configuration_model.rest if self.known else joint.rest(n)
        curves = any(o.curve is not None for o in observed.touching())
        weighed = weighs(joint.forward.data_vectors[n])
        self.paper: PaperFit | None = None
        self.no_paper = ""  # why it is missing
        if weighed and curves and 0.0 in {o.voltage_V for o in observed.touching()}:
            try:
                self.paper = identify(observed, self.rest, options.weight_exponent)
            except ModelError as error:
                self.no_paper = str(error)

    def sheet(self, varying: bool) -> ConfiguredSheet:
        """As a part of a model."""
        stated = self.observed.sheet.initial_curvature
        if self.known and stated is not None:
            rest = Along(stated[0], stated[1], np.zeros(len(stated[0])), "1/m")
        else:
            sigma = self.joint.rest_sigma(self.n, self.s_m)
            rest = Along(self.s_m, self.measured, sigma, "1/m")
        geometry = replace(self.observed.sheet, initial_curvature=(rest.s_m, rest.values))
        eibm = {v: Along.constant(p) for v, p in self.eibm.items()}
        if varying:
            eibm = {v: Along(self.s_m, *self.along[v], "N m") for v in self.voltages}
        return ConfiguredSheet(geometry, self.B, rest, eibm)

    def positions(self) -> Iterator[float]:
        """Yield those on the arc that it was fitted to, m."""
        for one in self.observed.touching():
            if one.position_m is not None:
                yield one.position_m

    def table(self, rows: tuple[ConditionResidual, ...]) -> ConfigurationFit:
        """Everything a report prints about it."""
        one, width = self.sheet(varying=False), self.observed.sheet.width_m
        own = tuple(r for r in rows if r.configuration == self.name)
        size = self.joint.mean_abs_eibm(self.n, self.voltages)
        return ConfigurationFit(
            configuration=self.name, B=self.B, B_per_width=self.B.scaled(1.0 / width, "N m"),
            E=one.E, eibm=self.eibm,
            eibm_mean={v: self.joint.mean_eibm(self.n, v) for v in self.voltages},
            eibm_mean_abs=size, eibm_mean_abs_per_width=size.scaled(1.0 / width, "N"), s_m=self.s_m,
            eibm_along_Nm=self.along, rest_per_m=self.rest(self.s_m),
            rest_measured_per_m=self.measured,
            rmse={"constant": rmse(own, "constant"), "varying": rmse(own, "varying")},
            paper=self.paper, B_known=weighs(self.joint.forward.data_vectors[self.n]),
        )  # fmt: skip


def _without(
    measurements: Measurements, options: FitOptions
) -> tuple[Measurements, tuple[str, ...]]:
    """Return the measurements without those held out, and the names of the held-out ones."""
    kept, names = [], []
    for condition in measurements.conditions:
        if options.holds_out(condition):
            where = f"{(condition.position_m or 0.0) * 1e3:g} mm"
            names.append(f"{condition.configuration}, {where}, {in_volts(condition.voltage_V)}")
        else:
            kept.append(condition)
    return replace(measurements, conditions=tuple(kept)), tuple(names)


def _left_out(measurements: Measurements, parts: Collection[str]) -> list[str]:
    """Return what has no valid reading, a sentence for each position and reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for c in measurements.conditions:
        if c.position_m is not None and c.configuration in parts and c.readings and not c.used():
            taken = any(r.kind != "discarded" for r in c.readings)
            none = "no reading is valid" if taken else "no reading that counts was taken"
            why = "; ".join(sorted({r.why for r in c.readings if r.why})) or none
            place = f"{c.configuration}, {c.position_m * 1e3:g} mm"
            found.setdefault((place, why), []).append(in_volts(c.voltage_V))
    return [
        f"{place}, {', '.join(dict.fromkeys(volts))} was left out: {why}"
        for (place, why), volts in found.items()
    ]


def _not_reached(rows: tuple[ConditionResidual, ...]) -> list[str]:
    """Return where a model has no equilibrium, a sentence for each model."""
    places: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        for kind, why in row.why.items():
            places.setdefault((IN_WORDS[kind], why), []).append(row.name)
    return [
        f"with {kind} the model {why} at {'; '.join(at)}: these are not in its errors, and its"
        " parameters are not to be trusted"
        for (kind, why), at in places.items()
    ]


def _implausible(scatter: Mapping[str, float]) -> list[str]:
    """Return a sentence for each scatter that no set-ups have: the fit took a misfit for it."""
    return [
        f"the {what} would differ from one set-up to the next by {100.0 * scatter[name]:.0f} %: the"
        " fit does not describe these data, and its parameters are not to be trusted"
        for name, what in (("stiffness", "stiffness"), ("eibm", "EIBM"))
        if scatter.get(name, 0.0) > MOST_SCATTER
    ]


def _missed(along: SheetModel) -> list[str]:
    """Return a sentence for each sheet whose data not even the EIBM along it describes."""
    found = [misfit.misfit(along, name) for name in along.sheets]
    return [
        f"the EIBM along the sheet, too, misses the data of '{one.configuration}' by"
        f" {one.in_words} (RMS){_of_forces(one)}: B and EIBM are not to be trusted; check the signs"
        " and units of forces, voltages and curves, or diagnose"
        for one in found
        if one.misses
    ]


def _of_forces(one: misfit.Misfit) -> str:
    if one.force_N is None or one.force_size_N is None:
        return ""
    return f", where the forces are {in_decimals(1e3 * one.force_size_N, 3)} mN"


def _bootstrap(joint: Joint, options: FitOptions) -> dict[str, float]:
    if not options.bootstrap:
        return {}
    deviations = joint.bootstrap(options.bootstrap, options.seed)
    result = {}
    for n, name in enumerate(joint.forward.names):
        for what, direction in joint.directions(n).items():
            stated = np.sqrt(direction @ joint.fitted.covariance @ direction)
            result[f"{name} {what}"] = float(np.std(deviations @ direction) / stated)
    return result


def _notes(
    measurements: Measurements,
    parts: dict[str, _Part],
    configurations: dict[str, ConfigurationFit],
    rows: tuple[ConditionResidual, ...],
    ratio: dict[str, float],
) -> tuple[str, ...]:
    notes = [*_left_out(measurements, parts), *offset_note(measurements)]
    if parts:
        notes += _implausible(next(iter(parts.values())).joint.scatter())
    for name, one in configurations.items():
        if not one.B_known:
            notes.append(not_weighed(name, one.B.value))
        elif one.B.sigma > POOR * one.B.value:
            share = 100.0 * one.B.sigma / one.B.value
            notes.append(
                f"B of '{name}' is hardly fixed by these data (±{share:.0f} %): only forces fix it,"
                " shapes fix Me/B"
            )
        if parts[name].no_paper:
            notes.append(
                "there are no parameters condition by condition, the paper's way:"
                f" {parts[name].no_paper}"
            )
        joint, n = parts[name].joint, parts[name].n
        notes += [
            f"the EIBM of '{name}' at {in_volts(volts)} changes by {100.0 * share:.0f} % along a"
            " run: leave out the first pulses, or diagnose"
            for volts, share in eibm_along_runs(joint, n).items()
            if share > UNSETTLED
        ]
        off = float(rms(one.rest_measured_per_m - one.rest_per_m))
        unsure = float(rms(joint.rest_sigma(n, parts[name].s_m)))
        least = 0.02 * np.max(np.abs(one.rest_per_m)) + 0.1
        if parts[name].known and off > max(least, BY_NOISE * unsure):
            notes.append(
                f"at 0 V the shapes of '{name}' differ from the stated initial curvature by"
                f" {off:.2f} per m"
            )
    notes += _not_reached(rows)
    notes += [
        f"the uncertainty of {name} is {value:.1f} times as large in simulated repeats"
        for name, value in ratio.items()
        if value > 1.25
    ]
    return tuple(notes)
