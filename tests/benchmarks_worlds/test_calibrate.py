"""Probabilities and sets of answers are fitted to questions whose right answers are known."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hidden_effects.records import Hid, Record, append
from benchmarks.worlds.calibrate import main
from benchmarks.worlds.fit_answers import (
    LEAST_CONTENT,
    RIDGES,
    content,
    content_in_each,
    fitted,
    in_other_worlds,
    log_loss,
    weights,
)
from benchmarks.worlds.right_answers import Labelled, labelled
from model.discrepancy.answers.calibrated_answers import (
    REPORTED,
    SOMETHING,
    CalibratedAnswers,
    reported,
)
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN, Alternative, ChoiceSet

pytestmark = pytest.mark.thorough

TRUE = {"behind": -1.5, "uneven": -3.0, "nothing": -1.0, "nothing_gain": -1.0, "unknown": -2.0}


def question(random: np.random.Generator, world: str) -> Labelled:
    """A choice set with random attributes, its right answer drawn with the true weights.

    The search says what is likely, or anything.
    """
    names = [
        Alternative(name, {"behind": float(random.exponential(1.5)), "uneven": random.uniform()})
        for name in ("gravity", "clamp_angle", "roll_offset")
    ]
    unknown = Alternative(UNKNOWN, {"unknown": 1.0})
    nothing = Alternative(NOTHING, {"nothing": 1.0, "nothing_gain": float(random.uniform(0, 3))})
    asked = ChoiceSet("gravity", (*names, unknown, nothing))
    true = CalibratedAnswers(TRUE, dict.fromkeys(REPORTED, 1.0)).probabilities(asked)
    says = next(iter(true)) if random.uniform() < 0.5 else str(random.choice(list(true)))
    asked = replace(asked, considered=says)
    right = random.choice(list(true), p=list(true.values()))
    return Labelled(world, "single", asked, frozenset({str(right)}))


@pytest.fixture(scope="module")
def questions():
    random = np.random.default_rng(1)
    return [question(random, world) for world in ("a", "b", "c") for _ in range(300)]


def test_the_weights_that_made_the_answers_are_found(questions):
    found = weights(questions, 0.1)
    for name, value in TRUE.items():
        assert found[name] == pytest.approx(value, abs=0.5)
    assert found["form_share"] == 0.0  # which no alternative has


def test_sets_hold_the_truth_in_95_percent_of_further_questions_whatever_is_said(questions):
    answers = fitted(questions).answers
    random = np.random.default_rng(2)
    further = [question(random, "d") for _ in range(1500)]
    judged = [answers.judged(q.asked) for q in further]
    for what in REPORTED:
        held = [
            bool(q.right & {*j.answers}) for q, j in zip(further, judged, strict=True)
            if reported(q.asked) == what
        ]  # fmt: skip
        assert 0.94 < np.mean(held) < 0.995
    assert np.mean([len(j.answers) for j in judged]) < 4.0
    sure = [(j.probabilities[j.likeliest], j.likeliest in q.right)
            for q, j in zip(further, judged, strict=True)]  # fmt: skip
    assert np.mean([ok for _, ok in sure]) == pytest.approx(np.mean([p for p, _ in sure]), abs=0.03)


@pytest.mark.parametrize(("count", "largest"), [(18, None), (19, 0), (38, 0), (39, 1), (59, 2)])
def test_a_content_is_the_quantile_that_exchangeable_cases_ask_for(count, largest):
    values = np.random.default_rng(0).permutation(np.arange(count) / 100.0)
    expected = 1.0 if largest is None else np.sort(values)[-1 - largest]
    assert content(values, np.ones(count)) == expected


def test_a_value_that_counts_little_moves_a_content_little():
    values, each = np.arange(60) / 100.0, np.ones(60)
    each[-4:] = 0.1
    assert content(values, np.ones(60)) == 0.57
    assert content(values, each) == 0.54


def test_a_right_answer_that_is_in_no_set_asks_for_all_answers():
    assert content(np.array([0.0] * 10 + [np.inf] * 10), np.ones(20)) == 1.0


def test_a_content_is_large_enough_for_the_worst_world():
    easy, hard = np.arange(80) / 1000.0, np.arange(20) / 25.0
    found, each = np.concatenate([easy, hard]), np.ones(100)
    worlds = ["easy"] * 80 + ["hard"] * 20
    pooled, worst = content(found, each), content_in_each(found, each, worlds)
    assert np.mean(hard <= pooled) < 0.95 <= np.mean(hard <= worst)
    assert content_in_each(found, each, ["all"] * 100) == pooled


def test_families_count_as_in_the_benchmark_however_many_were_run(questions):
    random = np.random.default_rng(3)
    sure = [replace(question(random, "a"), family="nothing", right=frozenset({NOTHING}))
            for _ in range(100)]  # fmt: skip
    few, many = (
        weights([*questions, *sure[:50]], 0.1),
        weights([*questions, *sure, *sure, *sure], 0.1),
    )
    assert many["nothing"] == pytest.approx(few["nothing"], abs=0.7)


def test_a_weight_never_has_a_sign_that_it_cannot_have():
    random, right = np.random.default_rng(4), frozenset({"gravity"})
    absurd = [
        Labelled(world, "single", ChoiceSet("gravity", (
            Alternative("gravity", {"large": 1.0 + random.uniform()}),
            Alternative("clamp_angle", {"large": random.uniform()}), Alternative(NOTHING, {}),
        )), right)
        for world in ("a", "b") for _ in range(40)
    ]  # fmt: skip
    assert weights(absurd, 0.1)["large"] == 0.0


def test_the_ridge_is_the_one_that_does_best_in_other_worlds(questions):
    few = questions[::30]
    losses = {ridge: log_loss(few, in_other_worlds(few, ridge)) for ridge in RIDGES}
    found = fitted(few)
    assert losses[found.ridge] == min(losses.values()) == found.log_loss


# ------------------------------------------------------------------------------- labels


def record(names: list[str], considered: list[str], **other: object) -> Record:
    hid = [Hid(n, n, 1.0, "", [""], None, {}, True, 20.0, 20.0) for n in names]
    asked = [
        ChoiceSet(one, (Alternative("gravity", {"behind": 0.1}), Alternative(UNKNOWN, {}),
                        Alternative(NOTHING, {"nothing": 1.0}))).to_json()
        for one in considered
    ]  # fmt: skip
    plain = Record(
        key="chain:single:0:1/diagnose", family="single", code="", truth=hid, near={}, left={},
        left_tolerant={}, force_gap_mN=0.0, curve_gap_mm=0.0, conditions="", choice_sets=asked,
    )  # fmt: skip
    return replace(plain, **other)  # type: ignore[arg-type]


def right(*args: object, **other: object) -> list[set[str]]:
    return [set(q.right) for q in labelled(record(*args, **other))]


def test_the_right_answer_is_what_is_hidden_and_nothing_besides():
    assert right(["gravity"], ["gravity", NOTHING]) == [{"gravity"}, {NOTHING}]
    assert right(["gravity"], ["clamp_angle", NOTHING]) == [{"gravity"}, {NOTHING}]
    assert right(["gravity"], [NOTHING]) == [{"gravity"}]
    assert right([], [NOTHING]) == [{NOTHING}]


def test_what_is_left_of_a_pair_is_the_answer_to_other_questions():
    pair = ["gravity", "clamp_angle"]
    assert right(pair, ["clamp_angle", NOTHING]) == [{"clamp_angle"}, {"gravity"}]
    assert right(pair, ["roll_offset", "gravity", NOTHING]) == [
        {"clamp_angle"}, {"gravity"}, {NOTHING},
    ]  # fmt: skip
    assert right(pair, ["roll_offset", NOTHING]) == [set(pair), set(pair)]


def test_what_no_catalogue_has_is_unknown_or_what_imitates_it():
    alike = {"gravity": 0.1, "clamp_angle": 0.6}
    outside = {"family": "outside", "left_tolerant": alike}
    assert right(["magnet"], ["clamp_angle", NOTHING], **outside) == [
        {UNKNOWN, "gravity"}, {UNKNOWN, NOTHING},
    ]  # fmt: skip
    assert right(["magnet"], [UNKNOWN], **outside) == [{UNKNOWN, "gravity"}]


def test_beside_an_effect_what_no_catalogue_has_is_one_question_more():
    both = {"family": "mixed", "left_tolerant": {"clamp_angle": 0.1}}
    assert right(["gravity", "magnet"], ["gravity", UNKNOWN, NOTHING], **both) == [
        {"gravity"}, {UNKNOWN, "clamp_angle"}, {UNKNOWN, NOTHING},
    ]  # fmt: skip


def test_what_nobody_could_see_and_what_failed_teaches_nothing():
    faint = [replace(record(["gravity"], [NOTHING]).truth[0], d=3.0)]
    assert labelled(record(["gravity"], [NOTHING], truth=faint)) == []
    assert labelled(record(["gravity"], [NOTHING], error="ValueError: no")) == []


# ------------------------------------------------------------------------------- the command


def test_the_command_fits_and_says_what_to(tmp_path, capsys):
    kept, made = tmp_path / "train.jsonl", tmp_path / "made.json"
    every = [
        replace(record(["gravity"], ["gravity", NOTHING]), key=f"{world}:single:{i}:500/diagnose",
                code="program/generator")
        for world in ("chain", "shooting") for i in range(12)
    ]  # fmt: skip
    append(kept, every)
    assert main([str(kept), "-o", str(made)]) == 0
    assert "truth: a name; truth in the set" in capsys.readouterr().out
    told = json.loads(made.read_text())
    assert told["made"]["worlds"] == {"chain": 12, "shooting": 12}
    assert told["made"]["seeds"] == [500]
    assert told["made"]["program"] == ["program"]
    assert told["made"]["questions"] == 48
    assert told["made"]["ridge"] in RIDGES
    assert told["contents"][SOMETHING] == LEAST_CONTENT  # of 24, all of them right
    assert told["contents"][NOTHING] == LEAST_CONTENT


def test_nothing_is_fitted_to_a_sealed_world(tmp_path, capsys):
    kept, made = tmp_path / "train.jsonl", tmp_path / "made.json"
    append(kept, [replace(record(["gravity"], [NOTHING]), key=f"{w}:single:0:1/diagnose")
                  for w in ("chain", "splines")])  # fmt: skip
    assert main([str(kept), "-o", str(made)]) == 2
    assert "sealed world 'splines'" in capsys.readouterr().err
    assert not made.exists()
