"""A pattern in the readings is one file: what the page about extending shows, and what is wrong."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from model.discrepancy import diagnose
from model.discrepancy.search import nonparametric_terms
from model.identification.data.data_vector import data_vector_of
from model.identification.reading_patterns import (
    ReadingPattern,
    ReadingsOfCondition,
    catalogue,
    reading_patterns,
)
from model.identification.reading_patterns.conformance import faults
from model.measurements import RigScale
from model.plugins import Part, PluginWarning
from tests.model.discrepancy.sessions import session

PAGE = Path(__file__).parents[3] / "docs" / "howto" / "extending.md"
HIGHER_N = 3e-4


@pytest.fixture
def pump(monkeypatch) -> ReadingPattern:
    """The example of the page."""
    module = ModuleType("pump_example")
    monkeypatch.setitem(sys.modules, "pump_example", module)
    section = PAGE.read_text(encoding="utf-8").split("## A pattern in the readings\n")[1]
    code = re.search(r"```python\n(.*?)```", section, re.DOTALL)[1]
    exec(compile(code, "extending.md", "exec"), module.__dict__)
    return module.PATTERN


def with_others(monkeypatch, *parts: ReadingPattern) -> None:
    """As if other distributions had brought these."""
    found = catalogue.FOLDER.parts()
    more = {one.name: Part(one.name, one, "others", "0.1") for one in parts}
    monkeypatch.setattr(catalogue, "FOLDER", SimpleNamespace(
        parts=lambda: {**found, **more}, origins=lambda: dict.fromkeys(more, "others 0.1"),
    ))  # fmt: skip


def pumped():
    """A session in which every fifth reading of a run is higher."""
    m = session()

    def higher(r):
        return replace(r, force_N=r.force_N + HIGHER_N * (round(r.time_s / 0.6) % 5 == 2))

    conditions = (replace(c, readings=tuple(map(higher, c.readings))) for c in m.conditions)
    return replace(m, conditions=tuple(conditions))


@pytest.mark.parametrize("name", reading_patterns())
def test_ours_are_found_in_no_noise(name):
    assert faults(reading_patterns()[name]) == []


def test_the_example_is_found_where_it_is_and_its_shape_is_something_unknown(pump, monkeypatch):
    assert faults(pump) == []
    found = pump.found_in([data_vector_of(pumped(), "long")], RigScale())
    assert (found.phase, found.higher_N) == (2, pytest.approx(HIGHER_N, rel=0.1))
    with_others(monkeypatch, pump)
    diagnosis = diagnose(pumped())
    assert (diagnosis.verdict, diagnosis.unknown.location) == ("unknown_effect", "load_cell")
    assert "in every 5th reading" in diagnosis.sentence
    assert diagnosis.unknown.profile[0] == pytest.approx(1e3 * HIGHER_N, rel=0.1)
    assert diagnosis.plugins["pump"] == "others 0.1"


@dataclass(frozen=True, kw_only=True)
class Failing(ReadingPattern):
    def found_in(self, data_vectors, scale):
        raise RuntimeError("no such table")


@dataclass(frozen=True, kw_only=True)
class Always(ReadingPattern):
    def found_in(self, data_vectors, scale):
        return self


@dataclass(frozen=True, kw_only=True)
class Short(ReadingPattern):
    def found_in(self, data_vectors, scale):
        return None

    def not_outliers(self, conditions):
        return []


@dataclass(frozen=True, kw_only=True)
class Spares(Short):
    def not_outliers(self, conditions):
        return [np.ones(len(one.force_N), dtype=bool) for one in conditions]


@pytest.mark.parametrize(
    ("kind", "why"),
    [
        (Failing, "RuntimeError: no such table"),
        (Always, "in readings that are noise alone"),
        (Short, "a truth value for each reading"),
        (Spares, "`not_outliers` is true of readings that are noise alone"),
        (ReadingPattern, "it has no `found_in`"),
    ],
)
def test_what_is_wrong_with_a_pattern_is_told(kind, why):
    (told,) = faults(kind(name="mine", meaning="mine", order=5))
    assert why in told


def test_one_of_others_that_fails_is_told_and_costs_nothing(monkeypatch):
    with_others(monkeypatch, Failing(name="mine", meaning="mine", order=5))
    with pytest.warns(PluginWarning, match=r"pattern 'mine' of others 0\.1 failed with Runtime"):
        assert catalogue.patterns_in([data_vector_of(session(), "long")], RigScale()) == ()


@pytest.mark.parametrize("flags", [[], [np.zeros(2, dtype=bool)]])
def test_flags_of_others_for_other_readings_are_told_and_leave_outliers_as_they_are(
    monkeypatch, flags
):
    mine = Short(name="mine", meaning="mine", order=5)
    monkeypatch.setattr(Short, "not_outliers", lambda *_: flags)
    with_others(monkeypatch, mine)
    one = ReadingsOfCondition(force_N=np.linspace(0.0, 1e-3, 10), by_eibm_N=1e-3)
    with pytest.warns(PluginWarning, match="`not_outliers` returned no truth value"):
        (kept,) = catalogue.not_outliers([one])
    assert not kept.any()


class Broken:
    """What was found fails in every way."""

    location = "load_cell"

    def without(self, readings):
        return readings.force_N[:2]

    def bases(self, at):
        raise RuntimeError("no such table")

    def in_other_data(self, data_vectors):
        raise RuntimeError("no such table")


@dataclass(frozen=True, kw_only=True)
class FindsBroken(ReadingPattern):
    def found_in(self, data_vectors, scale):
        return Broken()


def test_what_one_of_others_found_and_fails_is_told_and_costs_no_verdict(monkeypatch):
    with_others(monkeypatch, FindsBroken(name="mine", meaning="mine", order=5))
    with pytest.warns(PluginWarning) as told:
        diagnosis = diagnose(session())
    assert diagnosis.verdict == "nothing_missing"
    texts = {str(one.message) for one in told}
    assert any("no finite force for each reading" in text for text in texts)
    assert any("RuntimeError: no such table" in text for text in texts)


@pytest.mark.slow
def test_a_location_of_others_that_fails_is_told_and_costs_no_verdict(monkeypatch):
    def bases(_):
        raise RuntimeError("no such table")

    own = nonparametric_terms.location
    theirs = SimpleNamespace(bases=bases)
    monkeypatch.setattr(nonparametric_terms, "origins", lambda: {"load_cell": "others 0.1"})
    monkeypatch.setattr(
        nonparametric_terms, "location", lambda name: theirs if name == "load_cell" else own(name)
    )
    whose = r"the location of discrepancy 'load_cell' of others 0\.1"
    said = whose + r" failed with RuntimeError: no such table \(test_reading_patterns\.py, line "
    with pytest.warns(PluginWarning, match=said):
        assert diagnose(session()).verdict == "nothing_missing"
