"""Names that may hide in how the forms of others differ."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from benchmarks.worlds.cases import MIXED, PAPER, made, tasks
from benchmarks.worlds.generators import elements, shooting
from model.discrepancy import diagnose
from model.discrepancy.answers import hidden_names as module
from model.discrepancy.search import forward_selection as selection
from model.discrepancy.search.beside_strict_forms import HiddenName, StrictForms, hidden_names
from model.discrepancy.search.forward_selection import SearchResult, SelectionStep
from model.discrepancy.verdict import free_form_or_names
from model.identification.likelihood.effort import Effort
from model.measurements import ModelError
from tests.model.discrepancy.sessions import base_fit


def chances(monkeypatch, *found: tuple[str, float, float]) -> dict[str, float]:
    every = [
        HiddenName(name=name, ln_bayes_factor=gain, ahead=ahead) for name, gain, ahead in found
    ]
    monkeypatch.setattr(module, "hidden_names", lambda *_: every)
    return module.hidden_chances(None, ())  # type: ignore[arg-type]


def test_a_further_name_is_one_of_many_beforehand(monkeypatch):
    assert chances(monkeypatch, ("gravity", 30.0, 4.0)) == {"gravity": pytest.approx(0.5)}
    both = chances(monkeypatch, ("gravity", 30.0, 4.0), ("clamp_angle", 30.0, 4.0))
    assert both == {n: pytest.approx(1.0 / 3.0) for n in ("gravity", "clamp_angle")}
    # with so much evidence the search would have named it, had nothing spoken against it
    assert chances(monkeypatch, ("gravity", 2000.0, 2000.0)) == {
        "gravity": pytest.approx(0.852, abs=1e-3)
    }


def test_little_evidence_and_a_form_that_explains_much_more_are_not_told(monkeypatch):
    assert chances(monkeypatch, ("gravity", 4.0, 4.0), ("clamp_angle", 30.0, -5.0)) == {}
    assert chances(monkeypatch) == {}


def test_beside_something_unknown_a_name_explains_enough_and_most_of_what_it_explains_alone(
    monkeypatch,
):
    evidence = {
        "base": {"gravity": 30.0, "clamp_angle": 60.0, "arc_error": 2.0},
        "final": {
            "gravity": 20.0,
            "clamp_angle": 20.0,
            "arc_error": 7.0,
            "force_drift": 18.0,
            "surface_tension": 9.0,
        },
    }
    fits = {name: SimpleNamespace(found=(), solution=name) for name in evidence}
    monkeypatch.setattr(module, "candidates", lambda fitted, _: fitted.solution)
    monkeypatch.setattr(module, "best_scores", lambda _, pool, __: {
        name: SimpleNamespace(log_bayes=ln) for name, ln in evidence[pool].items()
    })  # fmt: skip
    told = module.chances_beside_unknown(fits["base"], fits["final"], ())  # type: ignore[arg-type]
    assert set(told) == {"gravity", "force_drift"}
    assert told["gravity"] > 0.5 > told["force_drift"] > 0.2


def test_a_fit_beside_a_free_form_that_does_not_settle_costs_no_verdict(monkeypatch):
    def unsettled(*_):
        raise ModelError("the fit did not settle")

    monkeypatch.setattr(free_form_or_names, "chances_beside_unknown", lambda *_: {"gravity": 0.8})
    monkeypatch.setattr(free_form_or_names, "replace", lambda problem, **_: problem)
    monkeypatch.setattr(free_form_or_names, "fit_mixed_model", unsettled)
    base = SimpleNamespace(problem=SimpleNamespace(effort=Effort()), theta=None, found=())
    final = SimpleNamespace(solution=SimpleNamespace(log_sigma=None))
    free = SimpleNamespace(score=SimpleNamespace(candidate=SimpleNamespace(columns=0), scale=1.0))
    assert free_form_or_names.name_beside(base, final, free, (), 6.0) is None  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_clamp_that_gives_way_is_named_beside_what_no_catalogue_has():
    *_, task = tasks("shooting", 3, 4001, [MIXED])
    assert [kind for kind, _ in task.hidden] == ["clamp_compliance", "crosstalk"]
    one = made(task)
    found = diagnose(one.session)
    assert (found.verdict, found.unknown.location) == ("unknown_effect", "load_cell")
    (clamp,) = found.effects
    assert (clamp.name, clamp.confusable_with) == ("clamp_compliance", ())
    assert clamp.probability > 0.9
    told, true = clamp.parameters["rotation_rad_per_Nm"], one.sizes["clamp_compliance"]
    assert told.value == pytest.approx(true, rel=0.2)
    assert [effect.name for effect in found.model.effects] == ["clamp_compliance", "unknown"]


@pytest.mark.slow
@pytest.mark.thorough
def test_a_name_that_fails_its_checks_beside_something_unknown_is_not_ruled_out():
    _, task = tasks("chain", 2, 4001, [MIXED])
    assert [kind for kind, _ in task.hidden] == ["sticking", "knocked_stage"]
    found = diagnose(made(task).session)
    assert (found.verdict, found.effects) == ("unknown_effect", ())
    assert found.not_ruled_out["roll_sticking"] > 0.5
    assert "roll_sticking" in found.reported_set
    assert any(note.startswith("not ruled out besides: ") for note in found.notes)


@pytest.mark.parametrize(
    ("gain", "lost", "names", "more"),
    [
        (20.0, 12.0, 1, True),
        (20.0, 13.0, 1, False),  # a form that differs explains as much
        (7.0, 0.0, 1, False),
        (20.0, 0.0, 2, False),  # a third name may be left of how two others differ
        (20.0, 0.0, 0, False),
    ],
)
def test_a_second_name_has_to_explain_more_than_a_form_that_differs(
    monkeypatch, gain, lost, names, more
):
    first, second = (
        SimpleNamespace(name=n, known=True, ln_bayes_factor=gain, fitted=n) for n in "ab"
    )
    strict = StrictForms(fitted="strict", lost=lost, ranking=[second])  # type: ignore[arg-type]
    monkeypatch.setattr(selection.StrictForms, "of", lambda *_: strict)
    monkeypatch.setattr(selection, "refine_best", lambda _, ranking: ranking)
    monkeypatch.setattr(selection, "_worth", lambda *_: second)
    monkeypatch.setattr(selection, "nonparametric_replaces_names", lambda *_: False)
    base = SimpleNamespace(deviance=0.0)
    turns = [SelectionStep(base, [first], first) for _ in range(names)] + [SelectionStep(base, [])]
    final = SimpleNamespace(deviance=-100.0, problem=SimpleNamespace(effort=Effort()))
    outcome = SearchResult(base, turns, final)
    found = selection._with_hidden(outcome, (), 6.0, 3)
    assert [one.name for one in found.chosen] == ["a"] * names + ["b"] * more
    assert (found.final == "b") == more


@pytest.mark.slow
def test_nothing_hides_beside_a_model_without_names():
    assert hidden_names(base_fit(), ()) == []


@pytest.mark.slow
@pytest.mark.thorough
def test_a_turned_load_cell_that_the_form_of_its_hysteresis_takes_up_is_told():
    hidden = {"load_cell_hysteresis": 0.273, "load_cell_misalignment": 0.203}
    found = diagnose(shooting.WORLD.measure(PAPER, hidden, 1321183981))
    assert [one.name for one in found.effects] == ["load_cell_hysteresis"]
    assert "load_cell_misalignment" in found.not_ruled_out


@pytest.mark.slow
@pytest.mark.thorough
def test_an_elongation_that_the_form_of_a_soft_clamp_takes_up_is_named():
    hidden = {"clamp_compliance": 175.8, "elongation_flexibility": 337.4}
    found = diagnose(elements.WORLD.measure(PAPER, hidden, 1145453732))
    assert {one.name for one in found.effects} == set(hidden)
