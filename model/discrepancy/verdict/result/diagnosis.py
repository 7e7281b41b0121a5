"""The result of `diagnose`, and its JSON."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal

from model.discrepancy.answers.choice_set import UNKNOWN, ChoiceSet
from model.discrepancy.at_rest.taken import DynamicsTaken
from model.discrepancy.criticism.check_result import CheckResult
from model.discrepancy.data_checks.contract import Suspicion
from model.discrepancy.verdict.result.candidates import DetectionLimit, Ranked, Signatures
from model.discrepancy.verdict.result.effects import Named, Unknown
from model.discrepancy.verdict.result.errors import BeforeAfter, ClosedGap, ErrorRow, Gap, Where
from model.discrepancy.verdict.result.json_numbers import json_number
from model.discrepancy.verdict.result.proposals import Next, Promise
from model.measurements import (
    Displayed,
    ModelError,
    Summary,
    dataframe,
    in_decimals,
)
from model.measurements.columns import of_rows
from model.parameter import Parameter
from model.sheet.sheet_model import SheetModel

if TYPE_CHECKING:
    import pandas as pd

Verdict = Literal[
    "effect_named", "nothing_missing", "indistinguishable", "unknown_effect", "cannot_tell"
]


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
            f"{in_decimals(before.force_rmse_mN, 3)} and"
            f" {in_decimals(after.force_rmse_mN, 3)} mN, neutral curve "
            f"{in_decimals(before.curve_rmse_mm, 3)} and {in_decimals(after.curve_rmse_mm, 3)} mm"
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

    @property
    def reported_set(self) -> dict[str, float]:
        """Return the answers among which the truth is in 95 % of sessions, the likeliest first.

        Names and 'unknown', each with its probability: what is named, what that may be confused
        with, and what is not ruled out. Empty where nothing is missing, or these data cannot tell.
        """
        chances = dict(self.not_ruled_out)
        for one in self.effects:
            for name in (one.name, *one.confusable_with, *one.or_else):
                chance = one.probability if name == one.name else one.probabilities.get(name, 0.0)
                chances[name] = max(chances.get(name, 0.0), chance)
        if self.unknown is not None:
            for name in (UNKNOWN, *self.unknown.confusable_with):
                chance = self.unknown.probabilities.get(name, 0.0)
                chances[name] = max(chances.get(name, 0.0), chance)
        return dict(sorted(chances.items(), key=lambda one: -one[1]))

    def to_json(self) -> dict[str, Any]:
        """Return the object that `diagnose --json` prints; what does not exist is null."""
        return {
            "verdict": self.verdict,
            "effects": [e.to_json() for e in self.effects],
            "invisible": list(self.invisible),
            "detection_limits": {name: one.to_json() for name, one in self.limits.items()},
            "unknown": None if self.unknown is None else self.unknown.to_json(),
            "model_effects": [one.name for one in self.model.effects],
            "reported_set": {name: json_number(p) for name, p in self.reported_set.items()},
            "not_ruled_out": {name: json_number(p) for name, p in self.not_ruled_out.items()},
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
