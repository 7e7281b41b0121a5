"""Names that these data cannot tell apart are reported as one class, everywhere."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.answers.calibrated_answers import Judged
from model.discrepancy.answers.choice_set import ChoiceSet
from model.discrepancy.answers.reported_set import not_ruled_out, of_name, with_alternatives
from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.criticise import Criticism
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.discrepancy.search.forward_selection import SearchResult, SelectionStep
from model.discrepancy.search.ranking import rank
from model.discrepancy.verdict import decision as decisions
from model.discrepancy.verdict import finding as verdicts
from model.discrepancy.verdict.decision import Decision, Judgement
from model.discrepancy.verdict.finding import Finding
from model.discrepancy.verdict.posterior import Choice
from model.discrepancy.verdict.result import Unknown
from model.effects import effect
from model.identification.likelihood.mixed_model_fit import fit_mixed_model
from model.identification.likelihood.model_state import Found
from tests.model.discrepancy.sessions import base_fit, session

PAIR = ("gravity", "clamp_angle")


def decided(
    probabilities: dict[str, float],
    answers: tuple[str, ...],
    rivals: tuple[str, ...] = (),
    *,
    doubted: bool = False,
    many: bool = False,
    overlooked: float = 1.0,
):
    """A decision for gravity, with the judged answers to that question."""
    base = base_fit()
    names = [
        configuration_model.sheet.configuration
        for configuration_model in base.problem.forward.configuration_models
    ]
    values = {name: {"load_N_per_m": 0.01 * (i + 1)} for i, name in enumerate(names)}
    one = replace(base, found=(Found(effect=effect("gravity"), values=values),))
    choice = Choice(
        effect=effect("gravity"), confidence=1.0, ln_bayes_factor=50.0, of_location=1.0,
        before=base, ranking=(),
    )  # fmt: skip
    failures = tuple(
        Failure(
            consequence=Consequence.EQUIVALENCE_CLASS,
            sentence="",
            effects=("gravity",),
            rivals=(name,),
        )
        for name in rivals
    )
    if doubted:
        failures += (
            Failure(
                consequence=Consequence.REJECT_UNLESS_PROBABLE, sentence="", effects=("gravity",)
            ),
        )
    if overlooked < 1.0:
        noticed = Failure(
            consequence=Consequence.IMPROBABLE_AMPLITUDE,
            sentence="",
            effects=("gravity",),
            overlooked=overlooked,
        )
        failures += (noticed,)
    return SimpleNamespace(
        known=one, named=[choice] * (3 if many else 1), unknown=None,
        nonparametric_explains_more=many,
        criticism=Criticism(failures=failures),
        choice_sets=(ChoiceSet("gravity", ()),), answers=(Judged(probabilities, answers),),
        hidden={},
    )  # fmt: skip


@pytest.fixture
def reported(monkeypatch):
    """Reports gravity; its form and its parameters are not looked at."""
    monkeypatch.setattr(verdicts, "form_of", lambda *_: (0.0, None))
    monkeypatch.setattr(verdicts, "parameters_of", lambda *_: {})

    def named(*args, **other):
        found = decided(*args, **other)
        return verdicts._named(found.named[0], found, found.known)

    return named


CLASS = {"clamp_angle": 0.966, "roll_offset": 0.03, "gravity": 0.004}


@pytest.mark.slow
def test_the_confidence_of_a_class_is_the_sum_over_its_members(reported):
    one = reported(CLASS, ("clamp_angle", "gravity"))
    assert one.confusable_with == ("clamp_angle",)  # the other one is in no set
    assert one.confidence == pytest.approx(0.97)
    assert one.probabilities == {"gravity": 0.004, "clamp_angle": 0.966}
    assert one.probability == 0.004
    assert one.or_else == ()


@pytest.mark.slow
def test_a_name_that_acts_otherwise_in_a_part_of_the_data_may_be_something_unknown(reported):
    one = reported({"gravity": 0.95, "unknown": 0.04}, ("gravity",), doubted=True)
    assert one.or_else == ("unknown",)
    assert one.probabilities == {"gravity": 0.95, "unknown": 0.04}


@pytest.mark.slow
def test_what_people_notice_is_less_probable_and_may_be_something_unknown(reported):
    one = reported({"gravity": 0.95, "unknown": 0.04}, ("gravity",), overlooked=0.4)
    assert one.or_else == ("unknown",)
    assert one.confidence == pytest.approx(0.38)
    assert one.probabilities == pytest.approx({"gravity": 0.38, "unknown": 0.61})


@pytest.mark.parametrize(
    ("consequence", "probability", "kept"),
    [
        (Consequence.REJECT_UNLESS_PROBABLE, 0.95, True),
        (Consequence.REJECT_UNLESS_PROBABLE, 0.7, False),
        (Consequence.REJECT, 0.99, False),
        (Consequence.IMPROBABLE_AMPLITUDE, 0.7, True),
        (Consequence.INDISTINGUISHABLE, 0.7, True),
    ],
)
def test_answers_that_are_sure_of_a_name_outweigh_a_doubt_but_no_impossible_amplitude(
    monkeypatch, consequence, probability, kept
):
    failure = Failure(consequence=consequence, sentence="", effects=("gravity",))
    judged = Judged({"gravity": probability, "unknown": 1.0 - probability}, ("gravity",))
    asked = SimpleNamespace(choice_sets=lambda: (ChoiceSet("gravity", ()),))
    monkeypatch.setattr(decisions, "criticise", lambda _: Criticism(failures=(failure,)))
    monkeypatch.setattr(decisions, "ComparedAnswers", lambda **_: asked)
    monkeypatch.setattr(decisions, "calibrated", lambda: SimpleNamespace(judged=lambda _: judged))
    monkeypatch.setattr(Judgement, "_without", lambda _self, found, _: replace(found, named=[]))
    choice = SimpleNamespace(effect=effect("gravity"), ranking=())
    found = Decision(
        named=[choice],
        known=SimpleNamespace(found=()),
        unknown=None,
        final=None,
    )  # type: ignore[arg-type]
    whole = Judgement(outcome=None, effects=(), threshold=6.0, enough=True)  # type: ignore[arg-type]
    assert bool(whole._revised(found).named) is kept


@pytest.mark.slow
@pytest.mark.parametrize(("likelier", "unknown"), [(0.6, None), (0.6, True), (0.2, None)])
def test_a_name_gives_way_to_a_likelier_one_of_its_question(monkeypatch, likelier, unknown):
    """The search takes what explains most; left-out positions may choose another."""
    answers = {"gravity": 0.4, "clamp_angle": likelier}
    judged = Judged(dict(sorted(answers.items(), key=lambda item: -item[1])), PAIR)
    fits = {"gravity": base_fit(), "clamp_angle": replace(base_fit())}
    ranking = [
        SimpleNamespace(
            name=name, known=True, fitted=fits[name], ln_bayes_factor=50.0, tried=(), compared=(),
            score=SimpleNamespace(candidate=SimpleNamespace(
                effect=effect(name), location=effect(name).location)),
        )
        for name in PAIR
    ]  # fmt: skip
    one = Choice(
        effect=effect("gravity"), confidence=0.5, ln_bayes_factor=50.0, of_location=1.0,
        before=base_fit(), ranking=ranking,
    )  # fmt: skip
    monkeypatch.setattr(Judgement, "_residual_terms", lambda _self, _: None)
    whole = Judgement(outcome=None, effects=(), threshold=6.0, enough=True)  # type: ignore[arg-type]
    found = Decision(
        named=[one],
        known=fits["gravity"],
        unknown=unknown,
        final=None,
    )  # type: ignore[arg-type]
    other = whole._with_likelier(found, (judged,), Criticism())
    if likelier < 0.4 or unknown:
        assert other is None
    else:
        assert [c.effect.name for c in other.named] == ["clamp_angle"]
        assert other.known is fits["clamp_angle"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("answers", "verdict"),
    [(("clamp_angle", "gravity"), "indistinguishable"), (("gravity", "unknown"), "effect_named"),
     (("gravity",), "effect_named")],
)  # fmt: skip
def test_effects_are_indistinguishable_where_a_set_has_two_of_them(reported, answers, verdict):
    one = reported({**CLASS, "unknown": 0.1}, answers)
    assert Finding._verdict(None, [one], None, "") == verdict


def test_what_is_no_name_is_no_member_of_the_class(reported):
    one = reported({"gravity": 0.8, "unknown": 0.2}, ("gravity", "unknown"))
    assert one.confusable_with == ()
    assert one.or_else == ("unknown",)
    assert one.confidence == 0.8
    assert one.probabilities == {"gravity": 0.8, "unknown": 0.2}


def test_the_rival_of_a_failed_check_is_in_the_set(reported):
    one = reported({"gravity": 0.97, "clamp_angle": 0.02}, ("gravity",), rivals=("clamp_angle",))
    assert one.confusable_with == ("clamp_angle",)
    assert one.confidence == pytest.approx(0.99)


def test_what_is_unknown_has_the_names_that_it_may_be_all_the_same():
    found = decided({"unknown": 0.6, **CLASS}, ("unknown", "clamp_angle", "gravity"))
    unknown = Unknown(
        location="eibm", configuration="", s_mm=np.zeros(1), profile=np.zeros(1), band=np.zeros(1),
        unit="", along="s", depends="",
    )  # fmt: skip
    assert with_alternatives(unknown, found).confusable_with == ()  # gravity is named beside it
    found.named = []
    one = with_alternatives(unknown, found)
    assert one.confusable_with == ("clamp_angle", "gravity")
    assert one.probabilities == {"unknown": 0.6, "clamp_angle": 0.966, "gravity": 0.004}
    assert one.to_json()["confusable_with"] == ["clamp_angle", "gravity"]


def test_answers_of_the_set_that_are_not_reported_are_not_ruled_out():
    found = decided(
        {"nothing": 0.8, "clamp_angle": 0.15, "gravity": 0.05}, ("nothing", "clamp_angle")
    )
    found.named, found.unknown = [], None
    # gravity was rejected by a check, and is as probable as that
    assert not_ruled_out(found, ()) == {"clamp_angle": 0.15, "gravity": 0.05}
    assert not_ruled_out(found, {"clamp_angle"}) == {"gravity": 0.05}
    assert not_ruled_out(found, {"gravity"}) == {}  # its set is reported with it
    found.hidden = {"gravity": 0.3, "charging_lag": 0.2}
    told = not_ruled_out(found, ())
    assert told == {"gravity": 0.3, "charging_lag": 0.2, "clamp_angle": 0.15}
    assert list(told) == ["gravity", "charging_lag", "clamp_angle"]  # the likeliest first
    found.hidden = {"clamp_angle": 0.85}  # of which the answer to a question knows more
    assert not_ruled_out(found, ())["clamp_angle"] == 0.15
    found.unknown = True  # the answers are told with it, and what it hides is told besides
    assert not_ruled_out(found, ()) == {"clamp_angle": 0.85}
    assert not_ruled_out(found, {"clamp_angle"}) == {}


def test_so_many_names_may_be_something_unknown(reported):
    one = reported({"gravity": 0.9, "unknown": 0.04}, ("gravity",), many=True)
    assert one.or_else == ("unknown",)
    # they share a location, too: together they may imitate what acts there
    assert one.probabilities == pytest.approx({"gravity": 0.765, "unknown": 0.175})


@pytest.mark.parametrize(("more", "others"), [(True, ("unknown",)), (False, ())])
def test_names_of_three_locations_are_doubted_where_a_nonparametric_term_explains_more(
    more, others
):
    named = [SimpleNamespace(effect=effect(n)) for n in ("gravity", "camera_roll", "charging_lag")]
    decision = SimpleNamespace(
        named=named, criticism=Criticism(), choice_sets=(ChoiceSet("gravity", ()),),
        answers=(Judged({"gravity": 0.95, "unknown": 0.04}, ("gravity",)),),
        nonparametric_explains_more=more, known=SimpleNamespace(found=()),
    )  # fmt: skip
    assert of_name("gravity", decision).or_else == others


@pytest.mark.parametrize(
    ("form", "found_after", "probability"),
    [(0.1, True, 0.8), (1.0, True, 0.94), (0.1, False, 0.94)],
)
def test_a_name_found_beside_the_strict_form_of_another_one_may_be_that_form(
    form, found_after, probability
):
    strong, weak = (SimpleNamespace(effect=effect(n)) for n in ("charging_lag", "gravity"))
    found = (SimpleNamespace(effect=strong.effect, form=form),
             SimpleNamespace(effect=weak.effect, form=1.0))  # fmt: skip
    found = found if found_after else found[::-1]
    judged = (Judged({"charging_lag": 0.97}, ("charging_lag",)),
              Judged({"gravity": 0.94, "unknown": 0.05}, ("gravity",)))  # fmt: skip
    decision = SimpleNamespace(
        named=[strong, weak], criticism=Criticism(), unknown=None, answers=judged,
        choice_sets=(ChoiceSet("charging_lag", ()), ChoiceSet("gravity", ())),
        nonparametric_explains_more=False, known=SimpleNamespace(found=found),
    )  # fmt: skip
    assert of_name("charging_lag", decision).confidence == 0.97
    one = of_name("gravity", decision)
    assert one.confidence == pytest.approx(probability, abs=2e-3)
    assert one.or_else == (("unknown",) if form < 1.0 and found_after else ())


def test_what_is_reported_is_not_invisible(reported):
    one = reported(CLASS, ("clamp_angle", "gravity"))
    unseen = {"gravity": "a", "clamp_angle": "b", "roll_offset": "c"}
    assert verdicts._not_reported(unseen, [one]) == {"roll_offset": "c"}


def finding(promised=()) -> Finding:
    """A search that has chosen gravity."""
    ready = prepare(session(), DiagnoseOptions())
    base = fit_mixed_model(ready.problem, ready.theta, ready.found)
    effects = [effect(name) for name in PAIR]
    ranking = rank(base, effects, locations=False)
    chosen = next(c for c in ranking if c.name == "gravity")
    size = replace(chosen, score=replace(chosen.score, amplitude=1.0))
    ranking = [size if c is chosen else c for c in ranking]
    step = SelectionStep(base, ranking, size)
    return Finding(
        measurements=session(), options=DiagnoseOptions(promised=promised), ready=ready,
        outcome=SearchResult(base, (step,), base), effects=effects, threshold=6.0,
        threshold_from="",
    )  # fmt: skip


@pytest.mark.thorough
def test_the_promise_of_a_measurement_is_judged_by_the_distance_that_is_proposed_by():
    one = finding()
    proposed = one.separating([effect(name) for name in PAIR])
    assert proposed.between == PAIR
    (promise,) = finding((proposed,))._promises()
    assert promise.proposal is proposed
    assert promise.found == pytest.approx(proposed.separation)  # nothing was measured since
    other_way = one.separating([effect(name) for name in PAIR[::-1]])
    assert other_way.separation == pytest.approx(proposed.separation)
    assert np.isfinite(proposed.expected)
