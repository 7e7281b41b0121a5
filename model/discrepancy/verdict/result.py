"""The result of `diagnose`, and its JSON."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from model.discrepancy.answers.choice_set import ChoiceSet
from model.discrepancy.at_rest.taken import DynamicsTaken
from model.discrepancy.criticism.check_result import CheckResult
from model.discrepancy.data_checks.contract import Suspicion
from model.effects import title
from model.measurements import Displayed, FloatArray, ModelError, Summary, dataframe
from model.measurements.columns import of_rows
from model.parameter import Parameter
from model.sheet.beam_problem import Under
from model.sheet.sheet_model import SheetModel

if TYPE_CHECKING:
    import pandas as pd

Verdict = Literal[
    "effect_named", "nothing_missing", "indistinguishable", "unknown_effect", "cannot_tell"
]


@dataclass(frozen=True, kw_only=True)
class ChosenValue:
    """A value that is not estimated but chosen among several, such as one of two forms."""

    value: float
    meaning: str
    probability: float  # posterior, given that the effect acts
    alternatives: tuple[tuple[str, float], ...]  # meaning and probability of the other ones

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        others = [{"meaning": m, "probability": round(p, 6)} for m, p in self.alternatives]
        return {
            "value": self.value,
            "meaning": self.meaning,
            "probability": round(self.probability, 6),
            "alternatives": others,
        }


@dataclass(frozen=True, kw_only=True)
class Named:
    """An effect that the model now includes."""

    name: str
    location: str
    parameters: Mapping[str, Parameter]  # by the catalogue's names; those of `configuration`
    by_configuration: Mapping[str, Mapping[str, Parameter]]  # where each has its own
    confidence: float  # posterior of the class: of the name and of `confusable_with` together
    confusable_with: tuple[str, ...]
    form_share: float  # of the effect's size that is deviation from the catalogue's form
    form: FormCurve | None = None
    choices: Mapping[str, ChosenValue] = field(default_factory=dict)  # by name of the parameter
    configuration: str = ""  # whose `parameters` are; empty: shared by all configurations
    # of each member of the class, and of `or_else`; older diagnoses have none
    probabilities: Mapping[str, float] = field(default_factory=dict)
    # answers of the set that are no names: `UNKNOWN`, `NOTHING`
    or_else: tuple[str, ...] = ()

    @property
    def probability(self) -> float:
        """Posterior of the name alone."""
        return self.probabilities.get(self.name, self.confidence)

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "name": self.name,
            "title": title(self.name),
            "slot": self.location,
            "parameters": {k: _parameter_object(p) for k, p in self.parameters.items()},
            "parameters_of": self.configuration or None,
            "interval90": {
                k: [_number(v) for v in p.interval()] for k, p in self.parameters.items()
            },
            "by_configuration": {
                name: {
                    k: {**_parameter_object(p), "interval90": [_number(v) for v in p.interval()]}
                    for k, p in own.items()
                }
                for name, own in self.by_configuration.items()
            },
            "confidence": round(self.confidence, 6),
            "confusable_with": list(self.confusable_with),
            "or_else": list(self.or_else),
            "probabilities": {k: round(p, 6) for k, p in self.probabilities.items()},
            "form_share": round(self.form_share, 4),
            **(
                {"choices": {k: c.to_json() for k, c in self.choices.items()}}
                if self.choices
                else {}
            ),
        }


@dataclass(frozen=True, kw_only=True)
class FormCurve:
    """An effect's inferred form, compared with the catalogue's."""

    along: str  # "s", "position", ...
    unit: str  # of the coordinate
    at: FloatArray
    catalogue: FloatArray
    inferred: FloatArray
    band: FloatArray  # standard uncertainty
    what: str  # of the values


@dataclass(frozen=True, kw_only=True)
class Unknown:
    """Something that no effect of the catalogue explains."""

    location: str
    configuration: str
    s_mm: FloatArray  # the coordinate, in `at_unit`: along sheet or arc, force, or time
    profile: FloatArray
    band: FloatArray  # standard uncertainty
    unit: str
    along: str  # "s", "place", "position", "force", "time"
    depends: str  # on voltage, position and time: one sentence
    at_unit: str = "mm"  # of the coordinate
    under: Under = ""  # which voltages it acts at, and which way
    advice: str = ""  # what to look at, in sentences; empty: nothing besides
    # effects of the catalogue that it may be all the same, and the probability of each answer;
    # older diagnoses have none
    confusable_with: tuple[str, ...] = ()
    probabilities: Mapping[str, float] = field(default_factory=dict)

    @property
    def peak_mm(self) -> float:
        """Where |profile| is largest."""
        return float(self.s_mm[int(np.argmax(np.abs(self.profile)))])

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "slot": self.location,
            "s_mm": self.s_mm.tolist(),
            "profile": self.profile.tolist(),
            "band": self.band.tolist(),
            "unit": self.unit,
            "along": self.along,
            "configuration": self.configuration,
            "depends": self.depends,
            "confusable_with": list(self.confusable_with),
            "probabilities": {k: round(p, 6) for k, p in self.probabilities.items()},
        }


@dataclass(frozen=True, kw_only=True)
class Where:
    """A cell in which simulation and measurement disagree."""

    observable: Literal["force", "curve", "signal"]
    configuration: str
    voltage_V: float
    position_mm: float | None
    s_mm: float | None
    z: float
    detail: str = ""  # reading or time, where it is that

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        result: dict[str, Any] = {
            "observable": self.observable, "configuration": self.configuration,
            "voltage_V": self.voltage_V, "position_mm": self.position_mm, "s_mm": self.s_mm,
            "z": round(self.z, 2),
        }  # fmt: skip
        if self.detail:
            result["detail"] = self.detail
        return result


@dataclass(frozen=True, kw_only=True)
class Gap:
    """How far a model is from the measurements: mean forces, curves, and both in time."""

    force_rmse_mN: float
    curve_rmse_mm: float
    chi2_per_dof: float  # of mean forces and curves
    drift_rmse_mN: float = float("nan")  # how a condition's readings go along the run
    pulse_rmse_mN: float = float("nan")  # parts of a pulse against its sampling point
    drift_rmse_mm: float = float("nan")  # how far out the readings' curves are, along the run

    def to_json(self) -> dict[str, float | None]:
        """Return the numbers; what does not exist is null."""
        return {k: _number(v) for k, v in self.__dict__.items()}


@dataclass(frozen=True)
class BeforeAfter:
    """The base model, and the model with the effects found."""

    before: Gap
    after: Gap

    def to_json(self) -> dict[str, Any]:
        """Both."""
        return {"before": self.before.to_json(), "after": self.after.to_json()}


@dataclass(frozen=True, kw_only=True)
class ClosedGap:
    """How much of a prediction error on left-out positions is closed, above the noise floor."""

    share: float  # 1 - (after^2 - floor^2)/(before^2 - floor^2)
    quantity: str  # whose error it is: that which stands out of the noise most
    before: float  # RMS, in `unit`
    after: float
    floor: float  # RMS that noise and scatter alone cause
    unit: str

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "share": round(self.share, 4), "quantity": self.quantity, "before": self.before,
            "after": self.after, "floor": self.floor, "unit": self.unit,
        }  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """A line of the ranking."""

    name: str
    location: str
    log_bayes: float
    size: float  # most likely size, in units of the plausible one
    detectability: float  # whitened length of the effect at its plausible size
    why_not: str = ""  # why it is not named although it may rank high


@dataclass(frozen=True, kw_only=True)
class ErrorRow:
    """One condition, measured and simulated; curves in metres, at the measured points."""

    configuration: str
    position_m: float | None
    voltage_V: float
    force_N: float
    sigma_N: float  # of the mean force, all noise and scatter included
    before_N: float
    after_N: float
    s_m: FloatArray
    x_m: FloatArray
    y_m: FloatArray
    before_xy_m: tuple[FloatArray, FloatArray]
    after_xy_m: tuple[FloatArray, FloatArray]
    before_off_m: FloatArray  # distance measured - simulated along the normal
    after_off_m: FloatArray
    held_out_before_N: float = float("nan")
    held_out_after_N: float = float("nan")
    # the models at the most likely offsets of the condition's set-up; not known of older diagnoses
    before_at_setup_N: float = float("nan")
    after_at_setup_N: float = float("nan")
    before_at_setup_xy_m: tuple[FloatArray, FloatArray] | None = None
    after_at_setup_xy_m: tuple[FloatArray, FloatArray] | None = None


@dataclass(frozen=True, kw_only=True)
class Next:
    """The next measurement, for a verdict with higher probability."""

    why: str
    extra: str  # name of the entry of the menu
    separation: float  # sigmas between the candidates now
    expected: float  # and after it
    minutes: float
    protocol: Mapping[str, Any]  # tables of a protocol.toml
    between: tuple[str, ...] = ()  # the candidates; older diagnoses do not say

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "why": self.why,
            "protocol": dict(self.protocol),
            "between": list(self.between),
            "separation_now": _number(self.separation),
            "separation_expected": _number(self.expected),
            "minutes": _number(self.minutes),
        }


@dataclass(frozen=True)
class Promise:
    """A proposed measurement that was made, and how far apart the candidates are with it."""

    proposal: Next
    found: float  # sigmas between the candidates, the measurement included

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "between": list(self.proposal.between),
            "extra": self.proposal.extra,
            "separation_before": _number(self.proposal.separation),
            "separation_promised": _number(self.proposal.expected),
            "separation_found": _number(self.found),
        }


@dataclass(frozen=True)
class Signatures:
    """How similar effects are in these data."""

    names: tuple[str, ...]
    detectability: FloatArray  # (n,) sigmas at the plausible size, the base refitted
    distance: FloatArray  # (n, n) sigmas between two of the size found or plausible
    cosine: FloatArray  # (n, n)


@dataclass(frozen=True, kw_only=True)
class DetectionLimit:
    """The amplitude from which on an effect would be seen beside what is named."""

    parameter: str
    value: float
    unit: str
    ratio: float  # over the prior scale

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {"parameter": self.parameter, "value": _number(self.value), "unit": self.unit}


@dataclass(frozen=True, kw_only=True, repr=False)
class Diagnosis(Displayed):
    """Everything that was found."""

    verdict: Verdict
    sentence: str
    effects: tuple[Named, ...]
    invisible: Mapping[str, str]  # name -> what would show it
    unknown: Unknown | None
    where: tuple[Where, ...]
    fitted: BeforeAfter
    held_out: BeforeAfter
    closed: float  # share of the gap on left-out conditions that the finding closes; NaN: none
    next_measurement: Next | None
    ranking: tuple[Ranked, ...]
    threshold: float  # ln of the Bayes factor from which on something is named
    threshold_from: str  # where it comes from
    signatures: Signatures
    classes: tuple[tuple[str, ...], ...]  # effects that these data cannot tell apart
    rows: tuple[ErrorRow, ...]
    scatter: Mapping[str, float]
    outliers: tuple[str, ...]
    notes: tuple[str, ...]
    model: SheetModel
    seconds: float = 0.0
    base: Mapping[str, Mapping[str, Parameter]] = field(default_factory=dict)  # B, EIBM
    # "distribution version" by name of the effects and locations of other distributions
    plugins: Mapping[str, str] = field(default_factory=dict)
    data_checks: tuple[Suspicion, ...] = ()  # what is suspicious about the data as stated
    closed_gap: ClosedGap | None = None  # the gap whose share `closed` is
    floor: Gap | None = None  # prediction error that noise and scatter alone cause
    promises: tuple[Promise, ...] = ()  # of proposals that were measured
    checks: tuple[CheckResult, ...] = ()  # what the verdict checks said of the names
    # names, and UNKNOWN, that are not reported but may be there, with their probabilities
    not_ruled_out: Mapping[str, float] = field(default_factory=dict)
    limits: Mapping[str, DetectionLimit] = field(default_factory=dict)  # of effects not named
    choice_sets: tuple[ChoiceSet, ...] = ()  # the answers that were compared, for benchmarks
    # by configuration: what the dynamics of the model that was given explain
    dynamics: Mapping[str, DynamicsTaken] = field(default_factory=dict)

    def summary(self) -> Summary:
        """Return the named effects with their parameters, and the verdict's sentence."""
        rows = [
            (one.name, what, f"{p.value:.4g}", *(f"{end:.4g}" for end in p.interval()), p.unit)
            for one in self.effects
            for what, p in one.parameters.items()
        ]
        columns = ("effect", "parameter", "value", "90 % from", "to", "unit") if rows else ()
        before, after = self.held_out.before, self.held_out.after
        errors = (
            "prediction error on left-out positions, RMS, before and after: force "
            f"{before.force_rmse_mN:.3f} and {after.force_rmse_mN:.3f} mN, neutral curve "
            f"{before.curve_rmse_mm:.3f} and {after.curve_rmse_mm:.3f} mm"
        )
        sentences = textwrap.wrap(f"{self.sentence} {errors}" if self.searched else self.sentence)
        return Summary(f"Diagnosis: {self.verdict}", columns, rows, tuple(sentences))

    def to_dataframe(
        self, part: Literal["effects", "ranking", "conditions"] = "effects"
    ) -> pd.DataFrame:
        """Return a part of the diagnosis as a pandas data frame.

        part: `effects` (a row for each parameter of each named effect), `ranking` (a row for each
        candidate) or `conditions` (a row for each condition: force measured, before, after; SI).

        Raises ModelError for another part, MissingPandasError where pandas is not installed.
        """
        if part == "effects":
            return dataframe(of_rows(list(self._effect_rows()), _EFFECT_COLUMNS))
        if part == "ranking":
            names = [f.name for f in fields(Ranked)]
            return dataframe({n: [getattr(one, n) for one in self.ranking] for n in names})
        if part == "conditions":
            return dataframe({n: [getattr(one, n) for one in self.rows] for n in _ERROR_COLUMNS})
        raise ModelError(f"a diagnosis has no part '{part}', but effects, ranking, conditions")

    def _effect_rows(self) -> Iterator[dict[str, Any]]:
        for one in self.effects:
            own = {one.configuration: one.parameters, **one.by_configuration}
            for configuration, parameters in own.items():
                for what, p in parameters.items():
                    low, high = p.interval()
                    values = (
                        one.name, configuration, one.location, one.probability, what, p.value,
                        p.sigma, low, high, p.unit,
                    )  # fmt: skip
                    yield dict(zip(_EFFECT_COLUMNS, values, strict=True))

    @property
    def searched(self) -> bool:
        """Whether anything was searched for: not in data that contradict what is stated of them."""
        return not any(one.severity == "stop" for one in self.data_checks)

    def to_json(self) -> dict[str, Any]:
        """Return the object that `diagnose --json` prints; what does not exist is null."""
        return {
            "verdict": self.verdict,
            "effects": [e.to_json() for e in self.effects],
            "invisible": list(self.invisible),
            "detection_limits": {name: one.to_json() for name, one in self.limits.items()},
            "unknown": None if self.unknown is None else self.unknown.to_json(),
            "not_ruled_out": {name: _number(p) for name, p in self.not_ruled_out.items()},
            "where": [w.to_json() for w in self.where],
            "gap": {"fitted": self.fitted.to_json(), "held_out": self.held_out.to_json()},
            "gap_closed": None if self.closed_gap is None else self.closed_gap.to_json(),
            "noise_floor": None if self.floor is None else self.floor.to_json(),
            "next_measurement": None
            if self.next_measurement is None
            else self.next_measurement.to_json(),
            "promises": [one.to_json() for one in self.promises],
            "checks": [one.to_json() for one in self.checks],
            "sentence": self.sentence,
            "notes": list(self.notes),
            "data_checks": [one.to_json() for one in self.data_checks],
            **self._dynamics_object(),
            **({"plugins": dict(self.plugins)} if self.plugins else {}),
        }

    def _dynamics_object(self) -> dict[str, Any]:
        """Return what the dynamics explain, and which names are what they leave."""
        if not self.dynamics:
            return {}
        beside = [one.name for one in self.model.effects if one.beside_dynamics]
        taken = {name: one.to_json() for name, one in self.dynamics.items()}
        return {"dynamics": {"explain": taken, "deviations": beside}}


_EFFECT_COLUMNS = (
    "effect", "configuration", "location", "probability", "parameter", "value", "sigma", "low90",
    "high90", "unit",
)  # fmt: skip
_ERROR_COLUMNS = (
    "configuration", "position_m", "voltage_V", "force_N", "sigma_N", "before_N", "after_N",
    "held_out_before_N", "held_out_after_N",
)  # fmt: skip


def _parameter_object(one: Parameter) -> dict[str, float | None]:
    return {"value": _number(one.value), "sigma": _number(one.sigma)}


def _number(value: float) -> float | None:
    """Return a number that JSON has; others are null."""
    return float(value) if np.isfinite(value) else None
