"""The effects of a result: named with their values, or unknown with a curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from model.discrepancy.verdict.result.json_numbers import json_number, parameter_object
from model.effects import title
from model.measurements import FloatArray
from model.parameter import Parameter
from model.sheet.beam_problem import Under


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
            "parameters": {k: parameter_object(p) for k, p in self.parameters.items()},
            "parameters_of": self.configuration or None,
            "interval90": {
                k: [json_number(v) for v in p.interval()] for k, p in self.parameters.items()
            },
            "by_configuration": {
                name: {
                    k: {**parameter_object(p), "interval90": [json_number(v) for v in p.interval()]}
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
    # where it may act, and the share of each location, the likeliest first; older diagnoses have
    # none
    locations: Mapping[str, float] = field(default_factory=dict)

    @property
    def other_locations(self) -> Mapping[str, float]:
        """Those that are not the reported one."""
        return {name: p for name, p in self.locations.items() if name != self.location}

    @property
    def peak_mm(self) -> float:
        """Where |profile| is largest."""
        return float(self.s_mm[int(np.argmax(np.abs(self.profile)))])

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "slot": self.location,
            "slots": {k: round(p, 6) for k, p in self.locations.items()},
            "s_mm": self.s_mm.tolist(),
            "profile": self.profile.tolist(),
            "band": self.band.tolist(),
            "unit": self.unit,
            "along": self.along,
            "at_unit": self.at_unit,
            "configuration": self.configuration,
            "depends": self.depends,
            "under": self.under,
            "advice": self.advice,
            "confusable_with": list(self.confusable_with),
            "probabilities": {k: round(p, 6) for k, p in self.probabilities.items()},
        }
