"""What is kept of each case: a line of JSON, so that a long run can be broken off and resumed."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from model.discrepancy.answers.choice_set import UNKNOWN


@dataclass(frozen=True)
class Hid:
    """What was hidden."""

    effect: str
    form: str
    size: float
    slot: str
    accepted_slots: list[str]
    place_mm: list[float] | None
    parameters: dict[str, float]
    as_in_catalogue: bool
    d: float  # whitened length, base and other hidden effects refitted
    alone: float  # with only the base refitted


@dataclass(frozen=True)
class Name:
    """What was named."""

    name: str
    confidence: float
    confusable_with: list[str]
    form_share: float
    # parameter -> configuration, "" for all -> value and ends of the 90 % interval
    parameters: dict[str, dict[str, list[float]]]
    or_else: list[str] = field(default_factory=list)  # answers of its set that are no names


@dataclass(frozen=True)
class Unseen:
    """Of an unknown effect."""

    slot: str
    configuration: str
    along: str
    peak: float  # in mm, or in seconds
    confusable_with: list[str] = field(default_factory=list)  # names that it may be all the same
    slots: dict[str, float] = field(default_factory=dict)  # where it may act, with each one's share


@dataclass(frozen=True)
class Further:
    """What was measured further because the first session did not allow a verdict."""

    extra: str  # entries of the menu, one after the other
    said: list[str]  # named from the first session alone
    reported: list[str]  # ... and what these may be confused with
    nearest: float  # sigmas by which the next effect of the catalogue was farther away, then
    expected: float  # sigmas promised between the two that looked alike, at first


Errors = tuple[float, float]  # root mean squares of force, N, and of curve, m


@dataclass(frozen=True, kw_only=True)
class Foretold:
    """Errors at conditions that a model was not given."""

    base: Errors
    written: Errors  # of the model with what was found
    floor: Errors  # of the base model where nothing is hidden

    @property
    def ratio(self) -> float:
        """Return the written model's error over the base model's."""
        return self.in_floors(self.written) / self.in_floors(self.base)

    @property
    def least(self) -> float:
        """Return the share of the base model's error that noise and scatter leave."""
        return self.in_floors(self.floor) / self.in_floors(self.base)

    @property
    def closed(self) -> float:
        """Return the share of the excess over the floor that is gone; NaN: there is none."""
        squares = [self.in_floors(e) ** 2 for e in (self.floor, self.base, self.written)]
        floor, before, after = squares
        return 1.0 - (after - floor) / (before - floor) if before > floor else math.nan

    def in_floors(self, errors: Errors) -> float:
        """Return force and curve together, each in units of its floor."""
        return math.hypot(*(e / f for e, f in zip(errors, self.floor, strict=True)))


@dataclass(frozen=True)
class Record:
    """One case with the diagnosis's answer."""

    key: str
    family: str
    code: str  # digest of the program that gave it
    truth: list[Hid]
    near: dict[str, float]
    left: dict[str, float]
    left_tolerant: dict[str, float]
    force_gap_mN: float
    curve_gap_mm: float
    conditions: str  # scatter, streams and the like, in words
    verdict: str = ""
    sentence: str = ""
    named: list[Name] = field(default_factory=list)
    unknown: Unseen | None = None
    invisible: list[str] = field(default_factory=list)
    ranking: list[tuple[str, float]] = field(default_factory=list)  # names of the catalogue only
    closed: float | None = None
    chi2_before: float | None = None  # on left-out positions, per number
    seconds: float = 0.0
    cpu_s: float = 0.0
    error: str = ""
    further: Further | None = None  # all else is then what both sessions together say
    baselines: dict[str, dict[str, Any]] = field(default_factory=dict)
    method: str = "diagnose"
    foretold: Foretold | None = None  # at conditions that the session does not hold
    left_out: Foretold | None = None  # at a position of the session that was not given
    # answers that labrig compared, with their attributes (`ChoiceSet.to_json`)
    choice_sets: list[dict[str, Any]] = field(default_factory=list)
    not_ruled_out: list[str] = field(default_factory=list)  # though it is not reported
    # of B and EIBM: value, ends of the 90 % interval, true value, by configuration and quantity
    base: dict[str, list[float]] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """What was hidden."""
        return tuple(t.effect for t in self.truth)

    @property
    def said(self) -> tuple[str, ...]:
        """What was named."""
        return tuple(n.name for n in self.named)

    @property
    def reported_set(self) -> set[str]:
        """All that a diagnosis says may be there: what is not ruled out, too."""
        return {*self.reported, *self.not_ruled_out}

    @property
    def reported(self) -> set[str]:
        """Names and 'unknown', and what these may be confused with."""
        found = {*self.said, *(c for n in self.named for c in (*n.confusable_with, *n.or_else))}
        return found if self.unknown is None else {*found, UNKNOWN, *self.unknown.confusable_with}

    @property
    def d(self) -> float:
        """The smallest of what is hidden."""
        return min((t.d for t in self.truth), default=0.0)

    @property
    def nearest(self) -> float:
        """By how many sigmas the catalogue's next effect is farther away than the right one."""
        return min(self.near.values(), default=float("inf"))

    def to_json(self) -> str:
        """One line."""
        return json.dumps(asdict(self))


def from_json(line: str) -> Record:
    """The record of a line."""
    raw = json.loads(line)
    raw["truth"] = [Hid(**t) for t in raw["truth"]]
    raw["named"] = [Name(**n) for n in raw["named"]]
    raw["unknown"] = None if raw["unknown"] is None else Unseen(**raw["unknown"])
    further = raw.get("further")
    raw["further"] = None if further is None else Further(**further)
    for name in ("foretold", "left_out"):
        if raw.get(name) is not None:
            raw[name] = Foretold(**{k: (v[0], v[1]) for k, v in raw[name].items()})
    raw["ranking"] = [(n, g) for n, g in raw["ranking"]]
    known = {f.name for f in fields(Record)}
    return Record(**{k: v for k, v in raw.items() if k in known})


def load(path: Path) -> list[Record]:
    """All whole lines of a file; a last one that was broken off is left out."""
    if not path.exists():
        return []
    result = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            result.append(from_json(line))
        except json.JSONDecodeError:
            continue
    return result


def append(path: Path, records: Iterable[Record]) -> None:
    """Add lines; after a broken one they begin a new line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    broken = path.exists() and path.stat().st_size and not path.read_bytes().endswith(b"\n")
    with path.open("a", encoding="utf-8") as file:
        file.writelines(("\n" if broken else "") + r.to_json() + "\n" for r in records)
