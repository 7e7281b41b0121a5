"""The contract of a data check: it compares a stated value with the data.

A data check looks for one kind of mistake: a wrong unit, sign, order or length. It may do so in
four ways, each a method that yields nothing unless it is overridden:
    `suspicions`  look at the measurements alone
    `of_stiffness`  look at the stiffness that the base model finds
    `changes`     propose data in which one datum is another one; each is fitted with the base
                  model, and the check speaks where these fit very much better than the data as
                  they are stated
    `of_failed_fit`  look at a configuration that the base model does not fit at all, and that no
                  change mends: an effect besides the mistake is too large for it
All are called before a search, must not block, keep no state, and change none of their
arguments. `changes` is only asked for where the base model does not fit.
"""

# ruff: noqa: ARG002 - the methods that a check may override do nothing with what they are given

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from model.measurements import Measurements

Severity = Literal["stop", "warn"]  # stop: nothing is searched for; warn: the search goes on


@dataclass(frozen=True, kw_only=True)
class Suspicion:
    """A datum that can hardly be right."""

    check: str  # name of the data check
    severity: Severity
    where: str  # file or table, and key: "radius_mm of [arc] in sheet.toml"
    configurations: tuple[str, ...]
    sentence: str  # what is suspicious, where, and which value would fit
    value: float | None = None  # which would fit, in `unit`; None: it is no number
    sigma: float | None = None  # its standard uncertainty
    unit: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return the object that `diagnose --json` and `fit --json` print."""
        numbers = (self.value, self.sigma)
        value, sigma = (None if v is None or not np.isfinite(v) else float(v) for v in numbers)
        return {
            "check": self.check, "severity": self.severity, "where": self.where,
            "configurations": list(self.configurations), "sentence": self.sentence,
            "value": value, "sigma": sigma, "unit": self.unit,
        }  # fmt: skip


# of the configurations, "'long' and 'short'", the value that fits and its standard uncertainty
Sentence = Callable[[str, float, float], str]


@dataclass(frozen=True, kw_only=True)
class Change:
    """One datum that might be another one."""

    where: str  # as in a `Suspicion`
    apply: Callable[[Measurements, float], Measurements]  # the data with another value
    sentence: Sentence
    # values to try; of a `continuous` datum to begin with
    values: tuple[float, ...]
    # of a continuous datum: a small change, and the value that leaves everything as it is
    step: float = 0.0
    stated: float = np.nan
    least: float = 0.0  # change of a continuous datum that is worth a word
    bounds: tuple[float, float] = (-np.inf, np.inf)
    unit: str = ""
    factor: float = 1.0  # from the value to `unit`
    # all configurations have the same: where they ask for several, it is an effect
    of_rig: bool = False

    @property
    def continuous(self) -> bool:
        """Whether the value is found by fitting."""
        return self.step > 0.0


@dataclass(frozen=True, kw_only=True)
class DataCheck:
    """One kind of mistake."""

    name: str  # also of its file
    meaning: str  # what is compared with what, a noun phrase
    order: int  # of presentation, and of precedence where two explain the data equally well

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """Return what the measurements alone say."""
        yield from ()

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """Return what to try where the base model does not fit one configuration: its data."""
        yield from ()

    def of_failed_fit(self, measurements: Measurements) -> Iterator[Suspicion]:
        """Return what is wrong with one configuration that fails and that no change mends."""
        yield from ()

    def of_stiffness(
        self, measurements: Measurements, B_Nm2: Mapping[str, float]
    ) -> Iterator[Suspicion]:
        """Return what the bending stiffness of each configuration says, where the model fits."""
        yield from ()
