"""What the page about extending says of an effect that depends on the solution is so."""

from __future__ import annotations

import re
import sys
from dataclasses import fields, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from labrig.testing import effect_faults
from model import ModelError, Parameter, predict
from model.effects.conformance import faults
from model.locations.examples import example_beam
from model.locations.quantities import BeamProblem, ContactSolution
from model.sheet.beam_problem import ActiveEffect
from model.sheet.prediction import predict_free
from tests.labrig.report_data import truth

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "extending.md"
HEADING = "### An effect that depends on the solution\n"
ROW = re.compile(r"^\| `(\w+)` \|([^|]*)\|[^|]*\|[^|]*\|$", re.MULTILINE)
VALUES = {"relative_change": 1.0, "threshold_per_m": 15.0}


def section() -> str:
    return PAGE.read_text(encoding="utf-8").split(HEADING)[1].split("\n## ")[0]


@pytest.fixture
def effect(monkeypatch):
    module = ModuleType("example")
    monkeypatch.setitem(sys.modules, "example", module)
    code = re.search(r"```python\n(.*?)```", section(), re.DOTALL)[1]
    exec(compile(code, "extending.md", "exec"), module.__dict__)
    return module.EFFECT


def test_the_tables_have_every_field_of_problem_and_solution_with_its_shape():
    beam, contact = example_beam()
    count = {"K": len(beam.voltage_V), "G": len(beam.s_m), "n": len(beam.reading_of)}
    text = section().partition("A `ContactSolution`")
    for rows, given, kind in ((text[0], beam, BeamProblem), (text[2], contact, ContactSolution)):
        shapes = dict(ROW.findall(rows))
        assert set(shapes) == {one.name for one in fields(kind)}
        for name, stated in shapes.items():
            value = getattr(given, name)
            if isinstance(value, np.ndarray):
                found = {
                    tuple(count[one] for one in re.findall(r"\w", shape))
                    for shape in re.findall(r"\(([^)]*)\)", stated)
                }
                assert value.shape in found, name


@pytest.fixture
def model(effect, monkeypatch):
    """A model with the effect of the page in it."""
    monkeypatch.setattr("model.sheet.applied_effects.catalogue", lambda: {effect.name: effect})
    parameters = {n: Parameter(value=v, sigma=0.0, unit="") for n, v in VALUES.items()}
    return replace(truth("long"), effects=(ActiveEffect(name=effect.name, parameters=parameters),))


@pytest.mark.slow
@pytest.mark.parametrize("touches", [True, False])
def test_the_curvature_of_a_solution_is_that_of_the_formula(effect, model, monkeypatch, touches):
    seen = []
    monkeypatch.setattr(type(effect), "beam", lambda _, beam, c, p: seen.append((beam, c)) or beam)
    if touches:
        predict(model, "long", 0.004, 2.0)
    else:
        predict_free(model, "long", 2.0)
    formula = re.search(r"solved curvature is `(.*?)`", section())[1]
    beam, contact = seen[-1]
    names = {f.name: np.nan_to_num(getattr(contact, f.name)) for f in fields(contact)}
    names |= {name: getattr(beam, name) for name in ("rest", "soft", "eibm", "bend", "stiffness")}
    names |= {name: names[name][..., None] for name in ("normal_N", "stiffness")}
    solved = eval(formula, {}, names)
    np.testing.assert_allclose(contact.curvature, solved, rtol=1e-6)
    free = re.search(r"\*\*Without contact\.\*\* `(.*?)`", section())[1]
    alone = np.allclose(contact.curvature, eval(free, {}, {"contact": contact, "beam": beam}))
    assert alone != touches


@pytest.mark.slow
def test_the_example_conforms_and_settles_where_one_that_follows_a_narrow_threshold_does_not(
    effect, model, monkeypatch
):
    assert faults(effect) == []

    def forces():
        return [predict(model, "long", at, v).F_N for at in (0.004, 0.014) for v in (2.0, -2.0)]

    plain_N = predict(truth("long"), "long", 0.004, 2.0).F_N
    assert not np.allclose(forces()[0], plain_N, rtol=0.01)

    def follows(_effect, beam, contact, p):
        beyond = np.abs(contact.curvature) > p["threshold_per_m"]
        return replace(beam, eibm=beam.eibm * (1.0 + p["relative_change"] * beyond))

    assert effect_faults(effect) == []
    monkeypatch.setattr(type(effect), "beam", follows)
    with pytest.raises(ModelError, match="do not settle"):
        forces()
    (said,) = effect_faults(effect)
    assert f"at {effect.amplitude.name} = " in said
    assert "do not settle" in said
