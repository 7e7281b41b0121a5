"""`dynamic_fit`: the sheet in time from its recorded runs, and the model file's part of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from labrig.analysis.motion.beginning import COARSE, StatedValues, beginning
from labrig.analysis.motion.noise import noise_at_first, noise_of_residuals
from labrig.analysis.motion.record import MotionRecord
from labrig.analysis.motion.rest_shape import MeasuredRest, rest_curvature
from labrig.errors import BadInputError
from labrig.progress import Progress, silent
from model import Along, ConfiguredSheet, ModelError, Parameter, SheetModel
from model.dynamics import DynamicBeam, DynamicSheet, LineModes, PronyTerm
from model.dynamics.identification import (
    DynamicParameter,
    Identification,
    NotConvergedError,
    RecordedRun,
    RecordingNoise,
    best_sheet,
    identify,
)
from model.measurements import FloatArray, SheetGeometry, geometry_difference

SAMPLE_S = 0.5  # after an edge, where the static part of a model file is sampled
NEAR, CLOSE = 0.5, 0.03  # the last step of a search, in standard deviations
POOR_CURVE_M = 1e-4  # the curves of pictures are ten times better
NEAR_SHARE = 0.4  # of the time of a fit, that to come near
THIN = 4  # samples, of which one is enough to come near
LINE_TERMS, ALONG, REST_NODES = 12, 21, 41
NO_SHEET = (
    "{}: no sheet in time explains the session: the search did not end, and {}. Record a free"
    " release ([extras] release = true); labrig diagnose says what the sheet at rest lacks."
)


class NoSheetInTimeError(BadInputError):
    """A session that moves like no sheet of the model."""


@dataclass(frozen=True, kw_only=True)
class DynamicFit:
    """One configuration in time, and what it was found from."""

    sheet: SheetGeometry
    runs: tuple[RecordedRun, ...]
    found: Identification
    noise: RecordingNoise
    stated: StatedValues
    source: str
    rest_sigma_per_m: FloatArray | None = None  # evenly along the sheet; None: k0 is as stated
    missing: tuple[str, ...] = ()

    @property
    def misses_curves(self) -> bool:
        """Return whether the curves are farther off the fitted sheet than pictures explain."""
        return _misses(self.noise)

    @property
    def off_the_curves(self) -> str:
        """Return how far the curves are off the fitted sheet, as the beginning of a sentence."""
        return _off(self.noise)

    @property
    def configured(self) -> ConfiguredSheet:
        """The sheet at rest: its relaxed stiffness, the EIBM half a second after an edge."""
        sigma = self.rest_sigma_per_m
        sigma = np.zeros(REST_NODES) if sigma is None else sigma
        s_m = np.linspace(0.0, self.sheet.free_length_m, len(sigma))
        rest = Along(s_m, self.found.beam.rest(s_m), sigma, "1/m")
        return ConfiguredSheet(self.sheet, self.found["B"].parameter, rest, self._eibm())

    @property
    def dynamic(self) -> DynamicSheet:
        """The sheet in time, as a model file holds it."""
        names = {one.name: one for one in self.found.parameters}
        by = {key: _by(names[name]) for name, key in _KEYS.items() if name in names}
        stated = {"source_ohm": "stated", "elongation_mass_kg_per_m": "stated"}
        terms = range(len(self.found.beam.material.shares))
        for i in terms:
            by[f"prony[{i}].share"] = _by(names[f"share_{i + 1}"])
            by[f"prony[{i}].time_s"] = _by(names[f"time_{i + 1}"])
        zero = {name: Parameter(value=0.0, sigma=0.0, unit="") for name in _KEYS}
        of = zero | {name: one.parameter for name, one in names.items()}
        end = self.stated.elongation_kg_per_m
        return DynamicSheet(
            mass_per_length_kg_per_m=of["mass_per_length"],
            viscous_time_s=of["viscous_time"],
            electrode_ohm_per_m=of["electrode_resistance"],
            capacitance_F_per_m=of["capacitance"],
            bulk_ohm_m=of["bulk_resistance"],
            leak_S_per_m=of["leak"],
            source_ohm=Parameter(value=self.stated.source_ohm, sigma=0.0, unit="ohm"),
            moment_per_volt_Nm=(of["moment_per_positive_volt"], of["moment_per_negative_volt"]),
            prony=tuple(
                PronyTerm(share=of[f"share_{i + 1}"], time_s=of[f"time_{i + 1}"]) for i in terms
            ),
            fluid=self.stated.fluid,
            elongation_mass_kg_per_m=(
                None if end is None else Parameter(value=end, sigma=0.0, unit="kg/m")
            ),
            determined_by=by | stated,
        )

    def _eibm(self) -> dict[float, Along]:
        """Return Me(s) of the largest voltages of both signs, `SAMPLE_S` after the opposite one."""
        line = self.found.beam.electrodes
        written = [round(v, 1) for run in self.runs for v in run.plan.drive.voltage_V.tolist()]
        low, high = min([0.0, *written]), max([0.0, *written])
        if line is None:
            return {}
        modes = LineModes(line, self.sheet.free_length_m, LINE_TERMS)
        s_m = np.linspace(0.0, self.sheet.free_length_m, ALONG)
        found = {}
        for volts, before in ((high, low), (low, high)):
            if volts:
                steps = np.array([100.0, SAMPLE_S])
                U = (
                    modes.at(s_m)
                    @ modes.respond(np.zeros(LINE_TERMS), steps, np.array([before, volts]))[-1]
                )
                Me = self.found.beam.moment_of(U)
                sign = "positive" if volts > 0.0 else "negative"
                share = self.found[f"moment_per_{sign}_volt"].log_sigma
                found[volts] = Along(s_m, Me, share * np.abs(Me), "N m")
        return found


_KEYS = {
    "mass_per_length": "mass_per_length_kg_per_m",
    "viscous_time": "viscous_time_s",
    "electrode_resistance": "electrode_ohm_per_m",
    "capacitance": "capacitance_F_per_m",
    "bulk_resistance": "bulk_ohm_m",
    "leak": "leak_S_per_m",
    "moment_per_positive_volt": "moment_per_volt_Nm.positive",
    "moment_per_negative_volt": "moment_per_volt_Nm.negative",
}


def _misses(noise: RecordingNoise) -> bool:
    return noise.curve_m > POOR_CURVE_M


def _off(noise: RecordingNoise) -> str:
    return f"the curves are {1e3 * noise.curve_m:.2f} mm off the fitted sheet"


def _by(parameter: DynamicParameter) -> str:
    return "data" if parameter.determined else "prior"


def dynamic_fit(
    records: Sequence[MotionRecord],
    stated: StatedValues,
    begin: DynamicBeam | None = None,
    *,
    progress: Progress = silent,
) -> DynamicFit:
    """Identify the sheet of some records; `begin`: a sheet known from before.

    First with usual noise, then with that of the residuals. Raises BadInputError; if it is known
    before the longest searches that no sheet explains the records: NoSheetInTimeError.
    """
    first = records[0]
    for one, other in pairwise(records):
        _require_same(one, other)
    runs = tuple(run for record in records for run in record.runs)
    source = ", ".join(record.source for record in records)
    if not any(run.plan.current for run in runs):
        raise BadInputError(
            f"{source}: no current of the sheet was recorded, without which nothing that follows a"
            " voltage can be told apart: wire its channel and state [current_sense] shunt_ohm in"
            " rig.toml."
        )
    begun = begin or beginning(first.sheet, runs, stated)
    try:
        noise = noise_at_first(runs)
        progress(0.0, f"{first.sheet.configuration}, fit to some samples")
        near, rest = _near(begun, runs, noise)
        progress(NEAR_SHARE, f"{first.sheet.configuration}, fit to all samples")
        noise = noise_of_residuals(near, runs, noise)
        found = identify(
            near, runs, noise, tolerance=CLOSE, near=True, must_converge=_misses(noise)
        )
    except NotConvergedError:
        off = _off(noise)
        raise NoSheetInTimeError(NO_SHEET.format(first.sheet.configuration, off)) from None
    except ModelError as error:
        raise BadInputError(f"{source}: {error}.") from None
    return DynamicFit(
        sheet=first.sheet, runs=runs, found=found, noise=noise, stated=stated, source=source,
        rest_sigma_per_m=None if rest is None else rest.sigma_per_m,
        missing=tuple(dict.fromkeys(text for record in records for text in record.missing)),
    )  # fmt: skip


def _near(
    beam: DynamicBeam, runs: Sequence[RecordedRun], noise: RecordingNoise
) -> tuple[DynamicBeam, MeasuredRest | None]:
    """Return a sheet near the answer, from fewer samples and with longer steps, and its k0.

    The amplifier's offset bends the sheet at rest, so its k0 is known when its moment per volt is.
    """
    rest = None
    fewer = [_thinned(run) for run in runs]
    for again in (False, True):
        beam = best_sheet(beam, fewer, noise, resolution=COARSE, tolerance=NEAR, near=again)
        rest = rest_curvature(beam, runs, noise.curve_m)
        if rest is None:
            break
        beam = replace(beam, rest=rest.rest)
    return beam, rest


def _thinned(run: RecordedRun) -> RecordedRun:
    plan = run.plan
    return RecordedRun(
        plan=replace(plan, time_s=plan.time_s[::THIN]),
        force_N=None if run.force_N is None else run.force_N[::THIN],
        current_A=None if run.current_A is None else run.current_A[::THIN],
        x_m=run.x_m,
        y_m=run.y_m,
    )


def _require_same(one: MotionRecord, other: MotionRecord) -> None:
    unlike = geometry_difference(one.sheet, other.sheet)
    if unlike is not None:
        raise BadInputError(
            f"{other.source}: its sheet has a {unlike.measure} of {unlike.second}, that of"
            f" {one.source} {unlike.first}; only sessions of the same sheet are fitted together."
        )


def model_of(fits: Sequence[DynamicFit], checksum: str) -> SheetModel:
    """Return the model of a file."""
    return SheetModel(
        sheets={fit.sheet.configuration: fit.configured for fit in fits},
        dynamic={fit.sheet.configuration: fit.dynamic for fit in fits},
        source=fits[0].source,
        checksum=checksum,
    )
