"""One mark after the end, and which runs and readings a list of marks leaves invalid."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from labrig.errors import BadInputError
from labrig.session.format import layout

Place = tuple[int, int | None]  # run and reading, from 0; None: the whole run


def now() -> str:
    """Return the time of day, ISO 8601, UTC."""
    return dt.datetime.now(dt.UTC).isoformat(timespec="seconds")


@dataclass(frozen=True, kw_only=True)
class Mark:
    """Who declared a reading (None: a whole run) invalid, or took that back, when and why.

    Raises BadInputError for texts that a file cannot hold.
    """

    run: int
    reading: int | None
    why: str
    who: str
    when: str = field(default_factory=now)  # ISO 8601, UTC
    invalid: bool = True  # False: a mark is taken back

    def __post_init__(self) -> None:
        for what, text, size in (
            ("reason of a mark", self.why, layout.MARK_WHY_BYTES),
            ("name of who marks", self.who, layout.MARK_WHO_BYTES),
        ):
            if not text.strip() or not text.isprintable():
                raise BadInputError(f"The {what} must be a text of one line.")
            if len(text.encode("utf-8")) > size:
                raise BadInputError(f"The {what} is too long; at most {size} bytes are kept.")

    @property
    def place(self) -> Place:
        """What is marked."""
        return self.run, self.reading

    def as_dict(self) -> dict[str, Any]:
        """Return what JSON holds; run and reading count from 1, as on the page."""
        return {
            "run": self.run + 1,
            "reading": None if self.reading is None else self.reading + 1,
            "invalid": self.invalid,
            "why": self.why,
            "who": self.who,
            "when": self.when,
        }


def named(run: int, reading: int | None) -> str:
    """Return what is marked in words."""
    return f"run {run + 1}" if reading is None else f"reading {reading + 1} of run {run + 1}"


def standing(marks: Iterable[Mark]) -> dict[Place, Mark]:
    """Return the marks that hold: of each place the last one, unless it was taken back."""
    last = {mark.place: mark for mark in marks}
    return {place: mark for place, mark in last.items() if mark.invalid}


def states_of(checksum: str, during: Iterable[Mark], later: Sequence[Mark]) -> tuple[str, ...]:
    """Return a checksum of the recording with its marks: after none, one, two ... of the later.

    It is that of the recording where the same is marked as at its end, so that a mark that was
    taken back leaves no trace.
    """
    first = [*during]
    return tuple(_state(checksum, first, later[:count]) for count in range(len(later) + 1))


def _state(checksum: str, during: list[Mark], later: Sequence[Mark]) -> str:
    before, after = standing(during).keys(), standing([*during, *later]).keys()
    if before == after:
        return checksum
    places = sorted((run, -1 if reading is None else reading) for run, reading in after)
    return hashlib.sha256(f"{checksum} {places}".encode()).hexdigest()
