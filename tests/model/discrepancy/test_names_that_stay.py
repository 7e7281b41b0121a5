"""What is reported in place of names that are rejected, and which names stay."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from model.discrepancy.search.refinement.other_starts import STRICT
from model.discrepancy.verdict import decision as module
from model.discrepancy.verdict.decision import Judgement
from model.discrepancy.verdict.probable_names import pieces
from model.effects import effect
from model.identification.likelihood.model_state import Found

BASE = SimpleNamespace(found=(), deviance=100.0)


def name(one: str, location: str, *, loop: bool = False) -> SimpleNamespace:
    return SimpleNamespace(effect=SimpleNamespace(name=one, location=location, by_history=loop))


GRAVITY, CELL = name("gravity", "even_moment"), name("force_offset", "load_cell")


def fit_with(*names: SimpleNamespace, deviance: float = 20.0) -> SimpleNamespace:
    found = tuple(SimpleNamespace(effect=one.effect, form=1.0) for one in names)
    return SimpleNamespace(found=found, deviance=deviance, problem=None, theta=None)


@pytest.fixture
def judgement(monkeypatch) -> Judgement:
    """A judgement that tells what it would decide, and makes no fit."""
    monkeypatch.setattr(module, "fit_mixed_model", lambda _, __, found: fit_with(*found))
    monkeypatch.setattr(module, "alone", lambda *_: False)
    monkeypatch.setattr(module, "misses_much", lambda *_: True)
    monkeypatch.setattr(module, "stands_beside", lambda *_: False)
    monkeypatch.setattr(module, "of_images", lambda _: "")
    monkeypatch.setattr(module, "unusual_images", lambda _: [])
    monkeypatch.setattr(module, "unusual_cell_noise", lambda _: None)
    told = {"_with_names": "names", "_with_unknown": "unknown"}
    for method, what in told.items():
        monkeypatch.setattr(
            Judgement, method,
            lambda _, named, *__, what=what: (what, [one.effect.name for one in named]),
        )  # fmt: skip
    return Judgement(
        outcome=SimpleNamespace(base=BASE, best_name=0.0), effects=(), threshold=6.0, enough=True
    )  # type: ignore[arg-type]  # fmt: skip


@pytest.mark.parametrize(
    ("first", "apart", "told"),
    [
        (50.0, 2.0, ("names", ["gravity"])),  # the rest of a form: nothing takes its place
        (50.0, 9.0, ("unknown", ["gravity"])),
    ],
)
def test_a_name_stays_where_another_is_rejected(monkeypatch, judgement, first, apart, told):
    rest = SimpleNamespace(
        first=SimpleNamespace(ln_bayes_factor=first),
        last=None,
        ln_bayes_factor_beside=apart,
        share=0.1,
    )
    monkeypatch.setattr(module, "residual_terms", lambda *_: rest)
    found = SimpleNamespace(named=[GRAVITY, CELL], known=fit_with(GRAVITY, CELL))
    assert judgement._without(found, ["force_offset"]) == told


@pytest.mark.parametrize(("form_of_second", "form"), [(1.0, 1.0), (STRICT, STRICT)])
def test_a_form_is_free_again_where_the_name_that_it_hid_is_dropped(
    judgement, form_of_second, form
):
    """As it was before that one was found; not where the one that is dropped was no such name."""
    values = {"long": {"angle_rad": 0.01}}
    first, second = (
        Found(effect=effect(one), values=values, form=f)
        for one, f in (("clamp_angle", STRICT), ("gravity", form_of_second))
    )
    free = SimpleNamespace(
        name="clamp_angle", fitted=SimpleNamespace(found=(replace(first, form=1.0),))
    )
    judgement.outcome.chosen = [free]
    (kept,) = judgement._kept((first, second), ["gravity"])
    assert (kept.effect.name, kept.form) == ("clamp_angle", form)


def test_doubtful_names_stay_where_nothing_is_better(monkeypatch, judgement):
    rest = SimpleNamespace(
        first=SimpleNamespace(ln_bayes_factor=50.0),
        last=None,
        ln_bayes_factor_beside=2.0,
        share=0.1,
    )
    monkeypatch.setattr(module, "residual_terms", lambda *_: rest)
    found = SimpleNamespace(named=[GRAVITY, CELL], known=fit_with(GRAVITY, CELL))
    assert judgement._without(found, []) is found


@pytest.mark.parametrize(
    ("named", "gains", "alone"),
    [
        ([GRAVITY, CELL], [1.0, 1.0, 1.0], False),  # left-out positions do not ask for the term
        ([GRAVITY, CELL], [3.0, 3.0, 3.0], True),
        ([GRAVITY, CELL], [1.0, 1.0], True),  # too few positions to tell
        ([GRAVITY], [1.0, 1.0, 1.0], True),
        ([CELL, name("force_drift", "load_cell")], [1.0, 1.0, 1.0], True),  # of one location
    ],
)
def test_two_names_of_two_locations_may_be_of_other_forms(
    monkeypatch, judgement, named, gains, alone
):
    monkeypatch.setattr(module, "alone", lambda *_: True)
    monkeypatch.setattr(module, "with_free_form", lambda *_: None)
    monkeypatch.setattr(module, "predictive_gains", lambda *_: gains)
    rest = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=50.0))
    known = fit_with(*named)  # explains 40, the term 50
    assert judgement._alone(rest, named, known) == alone


def test_two_loops_of_the_force_are_pieces_of_one_as_two_names_of_one_location_are():
    play, sticking = (name(n, n, loop=True) for n in ("load_cell", "position"))
    assert pieces([play, GRAVITY, sticking]) == ["load_cell", "position"]
    assert pieces([play, GRAVITY]) == []
    assert pieces([CELL, GRAVITY, name("force_drift", "load_cell")]) == [
        "force_offset", "force_drift",
    ]  # fmt: skip


def test_a_term_that_explains_much_more_stands_for_two_names(monkeypatch, judgement):
    monkeypatch.setattr(module, "alone", lambda *_: True)
    rest = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=60.0))
    assert judgement._alone(rest, [GRAVITY, CELL], fit_with(GRAVITY, CELL))


def test_no_term_stands_for_a_name_that_explains_as_much_beside_it(monkeypatch, judgement):
    monkeypatch.setattr(module, "alone", lambda *_: True)
    monkeypatch.setattr(module, "stands_beside", lambda _base, _free, one: one is CELL)
    rest = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=60.0))
    assert not judgement._alone(rest, [GRAVITY, CELL], fit_with(GRAVITY, CELL))
    assert judgement._alone(rest, [GRAVITY], fit_with(GRAVITY))


def test_a_name_that_misses_little_at_the_usual_scatter_stays(monkeypatch, judgement):
    monkeypatch.setattr(module, "alone", lambda *_: True)
    monkeypatch.setattr(module, "misses_much", lambda *_: False)
    rest = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=60.0))
    assert not judgement._alone(rest, [GRAVITY], fit_with(GRAVITY))
