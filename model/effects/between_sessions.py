"""What differs between sessions that are analysed together: a value for each of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import Effect, EffectParameter, Values
from model.measurements import FloatArray

LEAST_DIFFERENCE = 0.25  # of the largest value: less is one value of all sessions
# What is set to zero, wetted or mounted before each session begins anew with it.
GOES_ON = EffectParameter(
    name="goes_on",
    meaning="0: begins anew in each session; 1: goes on from session to session",
    unit="",
    prior_scale=0.0,
    low=0.0,
    high=1.0,
    starting_values=(0.0, 1.0),
)
_NUMBER = re.compile(r"session_(\d+)")


@dataclass(frozen=True, kw_only=True)
class BetweenSessions(Effect):
    """A quantity that has a value of its own in each session.

    Its parameters are `session_1`, `session_2` and so on, with the unit at the end. Where the base
    model has the mean of all sessions, they are differences `from_first` and begin with the second.
    """

    from_first: bool = False

    @property
    def claims(self) -> int:
        """See `Effect.claims`: values say that it is there, and that it differs."""
        return 1 if self.from_first else 2

    def for_sessions(self, count: int) -> Effect | None:
        """See `Effect.for_sessions`."""
        if count < 2:
            return None
        size, first = self.amplitude, 2 if self.from_first else 1
        others = (_of(size, number) for number in range(first + 1, count + 1))
        return replace(self, parameters=(size, *others))

    def differs(self, sizes: Sequence[float]) -> bool:
        """See `Effect.differs`: what is about the same in all sessions does not differ."""
        apart, most = max(sizes) - min(sizes), max(map(abs, sizes))
        return self.from_first or apart > LEAST_DIFFERENCE * most

    def change(self, session_number: FloatArray | float, p: Values) -> FloatArray:
        """Return the value in each session, of the shape of the numbers; of none: their mean."""
        values = {session_of(k.name): p.get(k.name, 0.0) for k in self.parameters}
        own = np.array([values.get(number, 0.0) for number in range(1, max(values) + 1)])
        if self.from_first:
            own = own - np.mean(own)
        table = np.array([np.mean(own), *own])
        number = np.asarray(session_number, dtype=float)
        return np.asarray(table[np.where(number < len(table), number, 0.0).astype(int)])


def one_a_session(size: EffectParameter) -> tuple[EffectParameter, ...]:
    """Return the parameters for two sessions, of which `size` is the first."""
    number = session_of(size.name)
    return (size,) if number == 2 else (size, _of(size, 2))


def sessions_in(names: Iterable[str]) -> int:
    """Return how many sessions these parameters are of; 0: they are not of sessions."""
    return max((session_of(name) for name in names), default=0)


def sessions_for(names: Iterable[str]) -> int:
    """Return for how many sessions an effect has such parameters; 0: for one."""
    some = tuple(names)
    return max(sessions_in(some), 2 if GOES_ON.name in some else 0)


def _of(size: EffectParameter, number: int) -> EffectParameter:
    def numbered(text: str) -> str:
        return text.replace(f"session {session_of(size.name)}", f"session {number}")

    name = size.name.replace(f"session_{session_of(size.name)}", f"session_{number}")
    return replace(
        size, name=name, meaning=numbered(size.meaning), starting_values=(0.0,), estimated=True
    )


def session_of(name: str) -> int:
    """Return the session that a parameter is of; 0: it is of none."""
    found = _NUMBER.match(name)
    return int(found.group(1)) if found else 0
