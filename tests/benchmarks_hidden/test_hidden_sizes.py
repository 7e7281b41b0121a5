"""Sizes: by the gap that an effect makes, or by what the caller measures."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.hidden_effects import (
    Case,
    Hiding,
    case,
    curve_gap_mm,
    force_gap_mN,
    form_of,
    hidden_session,
    size_for,
    size_for_gap,
)

pytestmark = pytest.mark.thorough


def test_an_offset_is_as_large_as_its_gap() -> None:
    hidden = hidden_session(case("force_offset", size=0.4, seed=1))
    assert force_gap_mN(hidden) == pytest.approx(0.4, rel=1e-6)
    assert curve_gap_mm(hidden) == 0.0


def test_an_effect_of_no_size_is_no_effect() -> None:
    hidden = hidden_session(case("camera_scale", size=0.0, seed=1))
    assert curve_gap_mm(hidden) == 0.0
    assert hidden.truth.effects[0].parameters == {}


def test_a_size_is_found_for_a_gap_and_for_what_the_caller_measures() -> None:
    hidden = case("load_cell_misalignment", seed=3)  # grows faster than its size
    size = size_for_gap(hidden, 0.25, tolerance=0.02)
    made = hidden_session(case("load_cell_misalignment", size=size, seed=3))
    assert force_gap_mN(made) == pytest.approx(0.25, rel=0.021)
    bare = hidden_session(hidden.bare).measurements
    zero = np.mean([r.force_N for r in bare.conditions[0].used()])

    def detectability(measurements) -> float:
        return abs(np.mean([r.force_N for r in measurements.conditions[0].used()]) - zero) / 1e-5

    size = size_for(case("force_offset", seed=3), 8.0, detectability)
    assert size == pytest.approx(0.08, rel=0.05)


def test_a_gap_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match=r"roll_friction \(sliding\) of 0.5 makes 0\.0\d+, not 3"):
        size_for_gap(case("roll_friction", seed=3), 3.0)


def test_what_cannot_be_hidden_is_named() -> None:
    with pytest.raises(KeyError, match="nothing called magic can be hidden"):
        form_of("magic")
    with pytest.raises(KeyError, match="its forms are exp, cosh, line, root"):
        hidden_session(case("nonuniform_eibm", "parabola"))
    with pytest.raises(ValueError, match=r"Case\.symmetric"):
        hidden_session(case("eibm_asymmetry"))


def test_two_effects_can_be_hidden_at_once() -> None:
    both = Case((Hiding("force_offset", size=0.1), Hiding("gravity", size=0.01)), seed=2)
    assert both.name == "force_offset + gravity"
    hidden = hidden_session(both)
    assert hidden.truth.names == ("force_offset", "gravity")
    alone = [case("force_offset", size=0.1, seed=2), case("gravity", size=0.01, seed=2)]
    first, second = (
        np.array([c.readings[0].force_N for c in hidden_session(a).measurements.conditions])
        for a in alone
    )
    bare = hidden_session(both.bare).measurements
    none = np.array([c.readings[0].force_N for c in bare.conditions])
    found = np.array([c.readings[0].force_N for c in hidden.measurements.conditions])
    assert found - none == pytest.approx(first + second - 2 * none, abs=1e-9)
