"""What a method is asked, and what it may answer.

A method is one file, NAME.py in this folder, with one function `answer(measurements) -> Answer`. It
is given nothing but the session. Files that begin with `_` are shared by several methods.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from benchmarks.hidden_effects.records import Name, Unseen
from model.measurements import Measurements
from model.parameter import Parameter
from model.sheet.prediction import Prediction

# by configuration, position along the arc (m) and voltage (V)
Foretell = Callable[[str, float, float], Prediction]


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a method says of a session. Nothing said, no verdict: nothing is missing."""

    verdict: str = ""  # as `diagnose` words it; empty: what follows from names and unknown
    # each with its posterior probability (1 where the method states none), what it may be confused
    # with, and parameters with 90 % intervals; the reported set is names and confusable ones
    named: list[Name] = field(default_factory=list)
    unknown: Unseen | None = None  # something that no catalogue has, and its location
    invisible: list[str] = field(default_factory=list)  # effects that this session could not show
    ranking: list[tuple[str, float]] = field(default_factory=list)  # best first
    closed: float | None = None  # share of the gap on left-out conditions, as the method states it
    not_ruled_out: list[str] = field(default_factory=list)  # may be there though it is not said
    # B (N m^2) and EIBM (N m), by configuration and quantity, named as `diagnose` does
    base: Mapping[str, Mapping[str, Parameter]] = field(default_factory=dict)
    foretell: Foretell | None = None  # None: the method predicts nothing
    choice_sets: list[dict[str, Any]] = field(default_factory=list)  # for `calibrate`; labrig's own


Method = Callable[[Measurements], Answer]
