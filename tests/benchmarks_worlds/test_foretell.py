"""Methods that write no model foretell conditions between those of the session all the same."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects.predicted import errors_of
from benchmarks.worlds.cases import PAPER
from benchmarks.worlds.conditions import unmeasured
from benchmarks.worlds.generators.elements import WORLD
from benchmarks.worlds.methods import (
    fixed_forms,
    gp_along_arc,
    kennedy_ohagan,
    repeats_bic,
    stlsq,
)
from benchmarks.worlds.methods._foretell import along_arc, likeliest_shapes, of_effects, of_model
from benchmarks.worlds.methods._signatures import Started
from model.measurements import Measurements

pytestmark = pytest.mark.thorough

DESIGN = replace(PAPER, readings=3, series=False, curve_points=17)
HIDDEN, SEED = {"load_cell_compliance": 0.3}, 17


@cache
def session() -> Measurements:
    """A load cell that gives way."""
    return WORLD.measure(DESIGN, HIDDEN, SEED)


@cache
def started() -> Started:
    """The base model of it."""
    return Started.of(session())


@cache
def truth():
    """What nobody measured."""
    return unmeasured(WORLD, HIDDEN, SEED, DESIGN)


@cache
def base_errors() -> tuple[float, float]:
    """Those of the base model."""
    return errors_of(of_model(started().base, session()), truth())


@pytest.mark.parametrize("method", [fixed_forms, stlsq, kennedy_ohagan, gp_along_arc])
def test_a_method_foretells_better_than_the_base_model(method) -> None:
    foretell = method.answer(session()).foretell
    force, curve = errors_of(foretell, truth())
    assert force < 0.6 * base_errors()[0]
    assert curve < 0.6 * base_errors()[1]


def test_a_method_whose_names_are_wrong_foretells_nevertheless() -> None:
    foretell = repeats_bic.answer(session()).foretell
    assert foretell is not None
    assert np.isfinite(foretell("long", 0.0125, 1.0).F_N)


def test_what_is_added_along_the_arc_is_added_between_positions_and_voltages() -> None:
    base = started().base
    forward = base.problem.forward
    added = np.zeros(forward.row_index.size)
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        k = block.trend_of[block.is_mean]
        smooth = (
            1e-4 * np.cos(configuration_model.stated_m[k] / 0.02) * configuration_model.voltage_V[k]
        )
        added[block.trend_rows[block.is_mean]] = smooth
        added[block.mode_rows[configuration_model.has_curve, 0]] = (
            3e-4  # the same everywhere along the curve
        )
    shapes = {f"force {c} 0": (0.02, 1e-6) for c in range(2)}
    shapes |= {f"curve {c} {m}": (0.02, 1e-6) for c in range(2) for m in range(10)}
    plain, more = of_model(base, session()), along_arc(base, added, shapes, session())
    for name in ("long", "short"):
        for volts in (2.0, -1.0, 0.0):
            before, after = (f(name, 0.0125, volts) for f in (plain, more))
            there = 1e-4 * np.cos(0.0125 / 0.02) * volts
            assert pytest.approx(there, abs=2e-6) == after.F_N - before.F_N
            apart = np.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
            assert apart == pytest.approx(3e-4, rel=0.02)
            turn = np.gradient(before.x_m) * (after.y_m - before.y_m)
            assert np.all(turn - np.gradient(before.y_m) * (after.x_m - before.x_m) > 0.0)


def test_an_effect_that_is_named_is_foretold_in_its_likeliest_shape() -> None:
    base, pool = started().base, started().pool
    (one,) = likeliest_shapes(base, pool, ["load_cell_compliance"])
    assert one.name == "load_cell_compliance"
    force, curve = errors_of(of_effects(base, [one], session()), truth())
    assert force < 0.6 * base_errors()[0]
    assert curve < 0.6 * base_errors()[1]
