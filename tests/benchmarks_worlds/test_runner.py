"""Cases of worlds are what they are said to be, records resume, and sealed worlds stay sealed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data_mistakes.mistakes import MISTAKES
from benchmarks.hidden_effects.records import Foretold, Hid, Name, Record, Unseen, append, load
from benchmarks.hidden_effects.visible import Visible
from benchmarks.worlds import cases, run, sealed
from benchmarks.worlds.__main__ import main
from benchmarks.worlds.cases import SHARES, Made, made, tasks
from benchmarks.worlds.conditions import left_out, unmeasured, without
from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators.chain import WORLD
from benchmarks.worlds.methods import boosted
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.registry import digest
from benchmarks.worlds.run import method, methods
from benchmarks.worlds.table import confidently_wrong, quantile_interval, rows
from model.measurements import Measurements

pytestmark = pytest.mark.thorough


def test_a_longer_run_has_the_cases_of_a_shorter_one() -> None:
    short, long = tasks("chain", 10, 5), tasks("chain", 40, 5)
    assert {t.key for t in short} <= {t.key for t in long}
    by_key = {t.key: t for t in long}
    assert all(by_key[t.key] == t for t in short)
    assert {t.family for t in short} == set(SHARES)


def test_other_seeds_have_other_sessions() -> None:
    assert not {t.seed for t in tasks("chain", 20, 1)} & {t.seed for t in tasks("chain", 20, 2)}


def test_what_is_hidden_is_as_visible_as_wanted() -> None:
    task = replace(tasks("chain", 8, 3, ["single"])[0], hidden=(("zero", 20.0),))
    one = made(task)
    assert one.visible.d[0] == pytest.approx(20.0, rel=0.15)
    force = [np.mean([r.force_N for r in c.used()]) for c in one.session.conditions]
    bare = [np.mean([r.force_N for r in c.used()]) for c in one.bare.conditions]
    assert np.subtract(force, bare) * 1e3 == pytest.approx(one.sizes["zero"])


def test_conditions_that_nobody_measured_lie_between_those_of_the_session() -> None:
    found = unmeasured(WORLD, {}, 4, Design())
    measured = {p for places in Design().positions_m.values() for p in places}
    assert len(found) == 20
    assert not {c.position_m for c in found} & measured
    assert {c.voltage_V for c in found} == {2.0, -2.0, 1.0, -1.0, 0.0}


def test_a_position_that_is_left_out_is_in_neither_conditions_nor_series() -> None:
    design = Design(readings=2, curve_points=9)
    whole = WORLD.measure(design, {}, 4)
    part = without(whole, 0.01)
    assert all(c.position_m != 0.01 for c in (*part.conditions, *part.series))
    assert len(left_out(WORLD, {}, 4, design, 0.01)) == 6
    assert len(part.conditions) == len(whole.conditions) - 6


def test_a_position_that_is_left_out_is_judged_amid_the_session() -> None:
    """A prediction is one of that time, and the sheet has dried by the last position."""
    there = {}
    for turn in (1, -1):
        design = Design(readings=2, curve_points=9)
        places = {name: own[::turn] for name, own in design.positions_m.items()}
        design = replace(design, positions_m=places)
        there[turn] = left_out(WORLD, {"drying": 0.4}, 4, design, 0.03)
    forces = [{(c.configuration, c.voltage_V): c.force_N for c in there[t]} for t in (1, -1)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)


def _record(**other: object) -> Record:
    hid = Hid("gravity", "heavy", 1.0, "even_moment", ["even_moment"], None, {}, True, 20.0, 20.0)
    plain = Record(
        key="chain:single:0:1/diagnose", family="single", code="", truth=[hid],
        near={"clamp_angle": 9.0}, left={}, left_tolerant={}, force_gap_mN=0.0, curve_gap_mm=0.0,
        conditions="",
    )  # fmt: skip
    return replace(plain, **other)  # type: ignore[arg-type]


def _value(records: list[Record], begins: str) -> str:
    return next(r.value for r in rows(records) if r.what.startswith(begins))


def test_a_sure_name_is_wrong_only_where_its_set_lacks_the_truth() -> None:
    sure = Name("clamp_angle", 0.95, ["gravity"], 0.0, {})
    assert not confidently_wrong(_record(named=[sure]))
    assert confidently_wrong(_record(named=[replace(sure, confusable_with=[])]))
    assert not confidently_wrong(_record(named=[Name("clamp_angle", 0.8, [], 0.0, {})]))
    assert confidently_wrong(_record(named=[sure], family="outside"))


def test_a_name_that_may_be_something_unknown_is_not_wrong_where_that_is_there() -> None:
    one = Name("clamp_angle", 0.95, [], 0.0, {}, or_else=["unknown"])
    outside = _record(named=[one], family="outside")
    assert outside.reported == {"clamp_angle", "unknown"}
    assert not confidently_wrong(outside)
    assert confidently_wrong(_record(named=[one]))
    assert _value([outside], "outside, d >= 30: 'unknown' in the reported set") == "-"
    strong = replace(outside, truth=[replace(outside.truth[0], d=40.0)])
    assert _value([strong], "outside, d >= 30: 'unknown' in the reported set") == "100.0%"
    assert _value([strong], "outside, d >= 30: 'unknown'") != "100.0%"


def test_what_is_not_ruled_out_is_in_the_reported_set_and_excuses_no_wrong_name() -> None:
    sure = Name("clamp_angle", 0.95, [], 0.0, {})
    found = _record(named=[sure], not_ruled_out=["gravity"])
    assert found.reported_set == {"gravity", "clamp_angle"}
    assert _value([found], "single, d >= 12: truth in the reported set") == "100.0%"
    assert _value([found], "the same, without what is not ruled out") == "0.0%"
    assert _value([found], "single, d >= 12: mean size of the set") == "2.00"
    assert confidently_wrong(found)


def test_an_effect_beside_something_unknown_is_right_if_both_are_told() -> None:
    plain = _record(family="mixed")
    other = replace(plain.truth[0], effect="magnet", d=40.0, accepted_slots=["time", "eibm"])
    name, unseen = Name("gravity", 0.95, [], 0.0, {}), Unseen("time", "", "time", 0.0)
    record = replace(plain, truth=[*plain.truth, other])
    both = replace(record, named=[name], unknown=unseen, verdict="unknown_effect")
    lost = replace(record, unknown=replace(unseen, slot="gravity"), verdict="unknown_effect")
    begins = ("effect and something outside: both", "the same: 'unknown'", "the same: the unknown")
    assert [_value([both, lost], line) for line in begins] == ["50.0%", "100.0%", "50.0%"]
    faint = replace(both, truth=[plain.truth[0], replace(other, d=20.0)])
    assert _value([faint], "effect and something outside: both") == "-"
    assert _value([replace(both, left_tolerant={"gravity": 0.1})], begins[0]) == "-"
    assert not confidently_wrong(both)
    assert confidently_wrong(replace(both, named=[replace(name, name="clamp_angle")]))


def test_what_an_unknown_may_be_all_the_same_is_in_the_reported_set() -> None:
    unseen = Unseen("eibm", "long", "s", 3.0, confusable_with=["gravity"])
    found = _record(unknown=unseen, verdict="unknown_effect")
    assert found.reported == {"unknown", "gravity"}
    assert _value([found], "single, d >= 12: truth in the reported set") == "100.0%"
    assert _value([found], "single, d >= 12: mean size of the set") == "2.00"


def test_confidence_is_compared_with_how_often_the_class_is_there() -> None:
    right = _record(named=[Name("clamp_angle", 0.97, ["gravity"], 0.0, {})])
    wrong = _record(named=[Name("clamp_angle", 0.97, [], 0.0, {})])
    line = "named: it is there, where its probability is 0.95"
    assert _value([right, right, right, wrong], line) == "75.0%"


def test_lines_count_what_they_say() -> None:
    right = _record(named=[Name("gravity", 0.99, [], 0.0, {})])
    wrong = _record(named=[Name("clamp_angle", 0.99, [], 0.0, {})])
    unknown = _record(unknown=Unseen("eibm", "long", "s", 3.0), verdict="unknown_effect")
    assert _value([right, wrong, unknown, right], "single, d >= 12: exactly") == "50.0%"
    assert _value([right, wrong], "confidently wrong") == "50.0%"
    assert _value([right, unknown], "in the catalogue, d >= 12: 'unknown'") == "50.0%"
    bare = replace(wrong, family="nothing", truth=[])
    assert _value([bare], "nothing hidden: something named") == "100.0%"


def test_a_gap_is_closed_above_its_floor() -> None:
    told = Foretold(base=(5e-3, 0.0), written=(1e-3, 0.0), floor=(1e-3, 1e-3))
    assert told.ratio == pytest.approx(0.2)
    assert told.closed == pytest.approx(1 - (1 - 2) / (25 - 2))
    named = [Name("gravity", 0.99, [], 0.0, {})]
    one = _record(left_out=told, named=named)
    assert _value([one], "left-out gap closed") == "104.3%"
    less = replace(one, left_out=replace(told, written=told.base))
    assert _value([*[one] * 9, less], "left-out gap closed") == "104.3%"
    assert _value([*[one] * 8, *[less] * 2], "the same, worst tenth") == "0.0%"


def test_the_worst_tenth_of_few_cases_is_hardly_known() -> None:
    drawn = np.random.default_rng(7).uniform(0.0, 1.0, (400, 60))  # 0.1 is below a tenth of them
    held = 0
    for values in drawn:
        low, high = (float(end.rstrip("%")) for end in quantile_interval(values, 0.1).split(" - "))
        held += low <= 10.0 <= high
    assert 0.88 * len(drawn) <= held <= 0.98 * len(drawn)  # ranks are whole: a little above 90 %


def test_a_record_with_predictions_is_read_back(tmp_path: Path) -> None:
    told = Foretold(base=(5e-3, 1e-3), written=(1e-3, 1e-4), floor=(1e-3, 1e-3))
    one = _record(foretold=told, method="stlsq")
    append(tmp_path / "r.jsonl", [one])
    assert load(tmp_path / "r.jsonl") == [one]


def test_a_run_goes_on_where_it_was_broken_off(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wanted = ["--worlds", "chain", "--family", "nothing", "--jobs", "1"]
    wanted += ["-o", str(tmp_path / "r.jsonl")]
    assert main([*wanted, "--cases", "1"]) == 0
    assert main([*wanted, "--cases", "2"]) == 0
    assert "1 cases to do" in capsys.readouterr().err
    assert [r.key for r in load(tmp_path / "r.jsonl")] == [
        "chain:nothing:0:0/diagnose", "chain:nothing:1:0/diagnose",
    ]  # fmt: skip


def test_several_worlds_are_also_scored_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = _record(named=[Name("gravity", 0.99, [], 0.0, {})], code="a/1")
    other = replace(there, key="shooting:single:0:1/diagnose", named=[], code="a/2")
    append(tmp_path / "r.jsonl", [there, other])
    assert main(["--score", str(tmp_path / "r.jsonl")]) == 0
    printed = capsys.readouterr().out
    assert "all worlds, diagnose: 2 cases" in printed
    assert "| single, d >= 12: exactly right | >= 92% | 50.0% | 2 |" in printed
    assert "CAUTION" not in printed


def test_records_of_two_states_of_the_program_are_not_mixed_silently(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = _record(code="a/1")
    append(tmp_path / "r.jsonl", [one, replace(one, key="chain:single:1:1/x", code="b/1")])
    main(["--score", str(tmp_path / "r.jsonl")])
    assert "CAUTION" in capsys.readouterr().out


def test_unknown_worlds_and_methods_are_refused_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--worlds", "nowhere", "-o", str(tmp_path / "r.jsonl")]) == 2
    assert main(["--methods", "nobody", "-o", str(tmp_path / "r.jsonl")]) == 2
    assert "there is no generator 'nowhere'" in capsys.readouterr().err


def test_a_sealed_world_is_refused_once_it_has_changed(tmp_path: Path) -> None:
    file = tmp_path / "sealed.toml"
    text = '[report]\nseeds = [7]\n[sealed]\nchain = "{}"\n'
    file.write_text(text.format(digest("chain")))
    sealed.check("chain", 7, file)
    with pytest.raises(ValueError, match="only measured with the seeds"):
        sealed.check("chain", 8, file)
    file.write_text(text.format("0" * 64))
    with pytest.raises(ValueError, match="not the one that was sealed"):
        sealed.check("chain", 7, file)


def test_a_session_that_stops_the_search_is_recorded_without_a_prediction(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Data that contradict what is stated of them have no model: that is no failure."""
    task = tasks("chain", 1, 3, ["single"])[0]
    bare = WORLD.measure(Design(), {}, 3)
    mistake = next(one for one in MISTAKES if one.name == "curves in m instead of mm")
    session, _ = mistake.make(bare, np.random.default_rng(3))
    visible = Visible((20.0,), (20.0,), {}, {}, {})
    one = Made(task, WORLD, {"zero": 1.0}, bare, session, visible)
    monkeypatch.setattr(run, "made", lambda _: one)
    (found,) = run.records(task)
    assert (found.error, found.verdict, found.foretold) == ("", "cannot_tell", None)


@pytest.mark.parametrize(
    ("said", "verdict"),
    [
        (Answer(), "nothing_missing"),
        (Answer(verdict="cannot_tell"), "cannot_tell"),
        (Answer(named=[Name("gravity", 0.9, [], 0.0, {})]), "effect_named"),
        (Answer(named=[Name("gravity", 0.9, ["force_drift"], 0.0, {})]), "indistinguishable"),
        (Answer(unknown=Unseen("eibm", "long", "s", 3.0)), "unknown_effect"),
    ],
)
def test_a_verdict_is_recorded_as_what_it_is(
    said: Answer, verdict: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    bare = WORLD.measure(Design(), {}, 3)
    task = tasks("chain", 1, 3, ["nothing"])[0]
    one = Made(task, WORLD, {}, bare, bare, Visible((), (), {}, {}, {}))
    monkeypatch.setattr(run, "made", lambda _: one)
    monkeypatch.setattr(run, "method", lambda _: lambda _: said)
    (found,) = run.records(task)
    assert found.verdict == verdict


@pytest.mark.parametrize("name", [m for m in methods() if m != "boosted"])
def test_a_method_says_of_nothing_hidden_that_nothing_is_unknown(name: str) -> None:
    assert method(name)(WORLD.measure(Design(), {}, 5)).unknown is None


@pytest.mark.parametrize("name", ["diagnose", "fixed_forms", "kennedy_ohagan", "stlsq"])
def test_a_method_names_a_large_effect(name: str) -> None:
    found = method(name)(WORLD.measure(Design(), {"crooked_clamp": 0.02}, 5))
    assert "clamp_angle" in {n.name for n in found.named}


def test_trees_without_training_say_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(boosted, "TRAINED", tmp_path / "none.npz")
    with pytest.raises(ValueError, match="run python -m"):
        boosted.answer(WORLD.measure(Design(), {}, 5))


def test_trees_learn_what_is_hidden_in_their_examples() -> None:
    pytest.importorskip("sklearn", reason="scikit-learn is missing: pip install -e .[worlds]")
    random = np.random.default_rng(1)
    truth = [("gravity",), ("zero",), ("gravity", "zero"), ()] * 20
    there = np.array([["gravity" in t, "zero" in t] for t in truth], dtype=float)
    trees = boosted.learned(there + 0.1 * random.standard_normal(there.shape), truth)
    assert set(trees) == {"gravity", "zero"}
    chance = {n: float(t.predict_proba(np.array([[1.0, 0.0]]))[0, 1]) for n, t in trees.items()}
    assert chance["gravity"] > 0.9
    assert chance["zero"] < 0.1


def test_a_generator_cannot_state_what_it_hides(monkeypatch: pytest.MonkeyPatch) -> None:
    class Telling:
        name, numerics, noise = WORLD.name, WORLD.numerics, WORLD.noise
        kinds, parameters = WORLD.kinds, WORLD.parameters

        def measure(self, design: Design, hidden: Mapping[str, float], seed: int) -> Measurements:
            found = WORLD.measure(design, hidden, seed)
            more = sum(hidden.values())
            sheets = {
                name: replace(s, initial_curvature=(s.initial_curvature[0],
                                                    s.initial_curvature[1] + more))
                for name, s in found.sheets.items() if s.initial_curvature is not None
            }  # fmt: skip
            return replace(found, sheets=sheets)

    monkeypatch.setattr(cases, "world", lambda _: Telling())
    task = replace(tasks("chain", 8, 3, ["single"])[0], hidden=(("zero", 20.0),))
    one = made(task)
    for name, sheet in one.session.sheets.items():
        assert sheet is one.bare.sheets[name]
