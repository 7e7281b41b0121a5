"""Facts as optics.json holds them: each under its name beside what is known of the camera."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from difflib import get_close_matches
from functools import partial
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import (
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from labrig.config.base import ClosedModel
from labrig.errors import BadInputError, LabrigError
from labrig.vision.facts.catalogue import origin_of, strip_facts
from labrig.vision.facts.contract import FactOf, Point, SearchConstraints, StripFact, objection

FloatArray = npt.NDArray[np.float64]
T = TypeVar("T")
SLIP = 0.8  # likeness of a key that was meant and mistyped
Facts = dict[str, Any]  # values by the facts' names


class StatesFacts(ClosedModel):
    """A table of optics.json in which facts may be stated, each as a key."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    facts_of: ClassVar[frozenset[FactOf]] = frozenset(FactOf)

    facts: Facts = Field(default_factory=dict, description="what is known of the strip, by name")

    @model_validator(mode="before")
    @classmethod
    def _with_facts(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not set(data) - (set(cls.model_fields) - {"facts"}):
            return data
        rest = {key: value for key, value in data.items() if key in cls.model_fields}
        if "facts" in rest:
            raise ValueError("facts is not a known key")
        facts: Facts = {}
        for key in (key for key in data if key not in cls.model_fields):
            fact = strip_facts().get(key)
            if fact is None or fact.is_direction or fact.of not in cls.facts_of:
                rest[key] = data[key]  # which is refused, with the keys that there are
            elif data[key] is not None:
                facts[key] = checked(fact, data[key], key)
        return rest | {"facts": facts}

    @classmethod
    def keys(cls) -> list[str]:
        """See `ClosedModel.keys`."""
        facts = (fact for fact in strip_facts().values() if not fact.is_direction)
        own = [key for key in cls.model_fields if key != "facts"]
        return [*own, *(fact.name for fact in facts if fact.of in cls.facts_of)]

    @classmethod
    def suggestion(cls, key: str) -> str:
        """See `ClosedModel.suggestion`."""
        if get_close_matches(key, cls.keys(), n=1, cutoff=SLIP):
            return ""
        return "a fact of a distribution that is not installed"

    @model_serializer(mode="wrap")
    def _with_facts_as_keys(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = handler(self)
        facts: Facts = data.pop("facts", {})
        return data | facts

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values; a fact is named as in the file, and None removes it."""
        changed = dict(update or {})
        fields = type(self).model_fields
        stated = {key: changed.pop(key) for key in [*changed] if key not in fields}
        if stated:
            facts = self.facts | stated
            changed["facts"] = {key: value for key, value in facts.items() if value is not None}
        return super().model_copy(update=changed, deep=deep)

    def __hash__(self) -> int:
        """Return a hash. A fact may be a list or a table: it counts by its name."""
        rest = (value for key, value in self.__dict__.items() if key != "facts")
        return hash((type(self), *rest, *sorted(self.facts)))

    @property
    def constraints(self) -> SearchConstraints:
        """What the facts tell the search, in their order."""
        if not self.facts:
            return SearchConstraints()
        return SearchConstraints.together(
            _constraints(fact, self.facts[name])
            for name, fact in strip_facts().items()
            if name in self.facts
        )

    def facts_that_are(self, of: FactOf) -> Facts:
        """Return the facts that are known of a strip, or of the pictures."""
        known = strip_facts()
        return {name: value for name, value in self.facts.items() if known[name].of == of}


def checked(fact: StripFact, value: object, where: str) -> Any:
    """Return a fact's value from a file or from clicks. Raises ValueError with a sentence."""
    try:
        return _of_fact(fact, where, lambda: fact.checked(value))
    except BadInputError as error:  # pydantic tells the file's name with it
        raise ValueError(str(error).rstrip(".")) from None


def read(fact: StripFact, stated: str) -> Any:
    """Return a fact's value from its option's text. Raises BadInputError."""
    return _of_fact(fact, f"{fact.option.flag} '{stated}'", lambda: fact.read(stated))


def joined(fact: StripFact, before: Any, stated: Any) -> Any:
    """Return a fact's value where one is known and another is stated. Raises BadInputError."""
    if before is None:
        return stated
    return _of_fact(fact, fact.option.flag, lambda: fact.joined(before, stated))


def moved(facts: Mapping[str, Any], to: Callable[[Point], Point]) -> Facts:
    """Return the facts in another picture of the same."""
    known = strip_facts()
    return {
        name: _of_fact(known[name], name, partial(known[name].moved, value, to))
        for name, value in facts.items()
    }


def places_of(fact: StripFact, value: Any) -> list[Point]:
    """Return each place of a fact's value."""
    found: list[Point] = []

    def keep(place: Point) -> Point:
        found.append(place)
        return place

    moved({fact.name: value}, keep)
    return found


def _constraints(fact: StripFact, value: Any) -> SearchConstraints:
    """Return what a fact tells; what its objections raise names it, too. Raises BadInputError."""

    def ask() -> SearchConstraints:
        found = fact.constraints(value)
        if not isinstance(found, SearchConstraints):  # other people's may be anything
            said = f"constraints returned {type(found).__name__}, not SearchConstraints"  # type: ignore[unreachable]
            raise TypeError(said)
        return found

    constraints = _of_fact(fact, fact.name, ask)
    if not constraints.objections:
        return constraints
    named = (partial(_objection, fact, objects) for objects in constraints.objections)
    return replace(constraints, objections=tuple(named))


def _objection(fact: StripFact, objects: Callable[[FloatArray], str], points_px: FloatArray) -> str:
    """Return why a curve cannot be the strip. Raises BadInputError where the fact cannot say it."""
    what, then = "was not compared with the curve:", f"; mend it, or leave {fact.option.flag} out"
    with _blaming(fact, fact.name, what, then):
        return objection(objects, points_px)


def _of_fact(fact: StripFact, where: str, ask: Callable[[], T]) -> T:
    """Return what a fact answers. Raises BadInputError, also for what other people's raises."""
    with _blaming(fact, where, "failed with"):
        try:
            return ask()
        except ValueError as error:
            raise BadInputError(f"{where}: {str(error).rstrip('.')}.") from None


@contextmanager
def _blaming(fact: StripFact, where: str, what: str, then: str = "") -> Iterator[None]:
    """Turn what other people's fact raises into a sentence that names it."""
    try:
        yield
    except LabrigError:
        raise
    except (Exception, SystemExit) as error:
        origin = origin_of(fact.name)
        if not origin:  # a fault of ours is none of the user's
            raise
        said = f"{type(error).__name__}: {str(error).rstrip('.')}"
        raise BadInputError(
            f"{where}: the strip fact '{fact.name}'{origin} {what} {said}{then}."
        ) from None
