"""Several names compete with each single one, and the likeliest answer is reported."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.answers.calibrated_answers import Judged
from model.discrepancy.criticism.check_result import Consequence
from model.discrepancy.criticism.kinds import one_name
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.search import one_name as search
from model.discrepancy.verdict.probable_names import improbable, maybe_absent


def ranked(name: str, gain: float, *, known: bool = True) -> SimpleNamespace:
    return SimpleNamespace(
        name=name, ln_bayes_factor=gain, known=known, fitted=SimpleNamespace(deviance=0.0)
    )


def outcome_of(*others: SimpleNamespace) -> SimpleNamespace:
    """A search that named two effects, of 20 and 10, each less what it paid for its size."""
    first, second = ranked("load_cell_compliance", 20.0), ranked("camera_scale", 10.0)
    base, one, two = (SimpleNamespace(deviance=d) for d in (100.0, 56.0, 32.0))
    first.fitted, second.fitted = one, two
    turns = [
        SimpleNamespace(before=base, ranking=[first, *others], chosen=first),
        SimpleNamespace(before=one, ranking=[second], chosen=second),
    ]
    return SimpleNamespace(base=base, steps=turns, final=two)


def compared(monkeypatch, *others: SimpleNamespace, share: float = 0.0) -> dict[str, float]:
    monkeypatch.setattr(search, "form_share", lambda *_: share)
    outcome = outcome_of(*others)
    names = ["load_cell_compliance", "camera_scale"]
    found = search.single_names(outcome, names, outcome.final)
    assert all(one.explained == pytest.approx(30.0) for one in found)
    return {one.candidate.name: one.ahead for one in found}


def test_a_single_name_is_compared_with_what_several_explain_together(monkeypatch):
    """The further name pays for being one of many."""
    found = compared(monkeypatch, ranked("elongation_flexibility", 28.0))
    assert found["elongation_flexibility"] == pytest.approx(28.0 - 30.0 + search.FURTHER_NAME_LN)


def test_what_explains_little_or_is_no_name_is_not_compared(monkeypatch):
    others = (ranked("gravity", 12.0), ranked("unknown:position", 40.0, known=False))
    assert compared(monkeypatch, *others) == {}


def test_a_single_name_that_is_mostly_deviation_from_its_form_is_not_compared(monkeypatch):
    assert compared(monkeypatch, ranked("nonuniform_eibm", 29.0), share=0.6) == {}


def test_one_name_has_no_other_in_its_place(monkeypatch):
    monkeypatch.setattr(search, "form_share", lambda *_: 0.0)
    outcome = outcome_of(ranked("elongation_flexibility", 28.0))
    assert search.single_names(outcome, ["load_cell_compliance"], outcome.final) == []


@pytest.mark.parametrize(("gain", "odds"), [(28.0, 1.0), (18.0, np.exp(-1.75)), (15.1, None)])
def test_a_single_name_shares_the_probability_as_far_as_it_comes_close(monkeypatch, gain, odds):
    """Four and a half are what its form may miss of thirty."""
    monkeypatch.setattr(search, "form_share", lambda *_: 0.0)
    monkeypatch.setattr(one_name, "_ahead_in_words", lambda *_: -np.inf)
    outcome = outcome_of(ranked("elongation_flexibility", gain))
    names = ("load_cell_compliance", "camera_scale")
    named = [SimpleNamespace(effect=SimpleNamespace(name=name)) for name in names]
    failures = list(one_name.CHECK.failures(NamedModel(outcome, named, outcome.final)))
    if odds is None:
        assert failures == []
        return
    (one,) = failures
    assert (one.consequence, one.effects) == (Consequence.INDISTINGUISHABLE, names)
    assert one.rivals == ("elongation_flexibility",)
    assert one.odds == pytest.approx((odds,))
    assert one.sentence.startswith("elongation flexibility alone explains about as much as")


def test_two_names_are_compared_with_one_in_the_best_wording_of_each(monkeypatch):
    """The first counts where none of them is, the second beside it."""
    outcome, words = outcome_of(), {"gravity": 21.0, "camera_scale": 19.0, "force_drift": 9.0}
    monkeypatch.setattr(
        one_name, "evidence", lambda _, __, effects: {e.name: words[e.name] for e in effects}
    )
    first, second, rival = (
        SimpleNamespace(name=n) for n in ("camera_scale", "force_drift", "gravity")
    )
    named = [SimpleNamespace(effect=second, ln_bayes_factor=9.0, before=None),
             SimpleNamespace(effect=first, ln_bayes_factor=19.0, before=None)]  # fmt: skip
    fitted = SimpleNamespace(solution=SimpleNamespace(log_sigma=None))
    candidate = SimpleNamespace(
        name="gravity", score=SimpleNamespace(candidate=SimpleNamespace(effect=rival))
    )
    judged = NamedModel(outcome, named, fitted)

    def ahead(explained: float) -> float:
        single = search.SingleName(candidate=candidate, explained=explained, ahead=0.0)
        return one_name._ahead_in_words(judged, single)

    assert ahead(30.0) == pytest.approx(21.0 - 28.0 + search.FURTHER_NAME_LN)
    assert ahead(60.0) == -np.inf  # a straight line is far from what was fitted


@pytest.mark.parametrize(
    ("name", "unknown", "nothing", "rejected"),
    [
        (0.6, 0.35, 0.05, False),
        (0.48, 0.44, 0.08, False),  # the likeliest, and something is there
        (0.44, 0.48, 0.08, True),
        (0.45, 0.30, 0.25, True),  # maybe nothing is there at all
    ],
)
def test_a_name_gives_way_where_something_unknown_or_nothing_is_likelier(
    name, unknown, nothing, rejected
):
    chances = {"gravity": name, "unknown": unknown, "nothing": nothing}
    assert improbable(Judged(chances, ("gravity",))) == rejected


def test_a_name_that_a_form_hides_is_not_named_where_nothing_is_not_ruled_out():
    first, second, third = (
        SimpleNamespace(effect=SimpleNamespace(name=name), form=form)
        for name, form in (("charging_lag", 0.1), ("frame_delay", 1.0), ("gravity", 1.0))
    )
    sure, unsure = Judged({}, ("frame_delay",)), Judged({}, ("frame_delay", "nothing"))
    assert maybe_absent("frame_delay", unsure, (first, second))
    assert not maybe_absent("frame_delay", sure, (first, second))
    assert not maybe_absent("frame_delay", unsure, (second, third))  # in no form of its own
    assert not maybe_absent("charging_lag", unsure, (first, second))
