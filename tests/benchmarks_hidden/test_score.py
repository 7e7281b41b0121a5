"""The table's lines count what they say, and a suite that grows keeps the cases it had."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.hidden_effects import CATALOGUE, OUTSIDE, forms_of
from benchmarks.hidden_effects.compared import table as compared
from benchmarks.hidden_effects.figures import matrix
from benchmarks.hidden_effects.records import Further, Hid, Name, Record, Unseen, append, load
from benchmarks.hidden_effects.score import (
    Row,
    confidently_wrong,
    failures,
    intervals,
    means_right,
    scored,
    table,
    wilson,
)
from benchmarks.hidden_effects.suite import FULL, tasks

pytestmark = pytest.mark.thorough


def hid(effect: str, d: float = 20.0, **other: Any) -> Hid:
    plain = Hid(
        effect=effect,
        form="a",
        size=1.0,
        slot="eibm",
        accepted_slots=["eibm"],
        place_mm=None,
        parameters={},
        as_in_catalogue=False,
        d=d,
        alone=d,
    )
    return replace(plain, **other)


def said(name: str, confidence: float = 0.99, *also: str, **parameters: Any) -> Name:
    return Name(name, confidence, list(also), 0.1, parameters)


def record(family: str, truth: list[Hid], named: list[Name], **other: Any) -> Record:
    plain = Record(
        key=f"{family}:0:0",
        family=family,
        code="",
        truth=truth,
        near={},
        left={},
        left_tolerant={},
        force_gap_mN=0.3,
        curve_gap_mm=0.1,
        conditions="",
    )
    near = {"gravity": 9.0}
    return replace(plain, near=near, named=named, verdict="effect_named", **other)


def row(records: list[Record], begins: str) -> Row:
    return next(r for r in scored(records) if r.what.startswith(begins))


def test_wilson_s_interval_is_that_of_the_formula() -> None:
    low, high = wilson(0, 100)
    assert low == pytest.approx(0.0, abs=1e-12)
    assert high == pytest.approx(2.7055 / 102.7055, rel=1e-4)
    assert wilson(50, 100) == pytest.approx((0.4189, 0.5811), abs=2e-4)
    assert wilson(0, 0) == (0.0, 1.0)


def test_a_name_where_nothing_is_hidden_counts_and_says_which_case_it_was() -> None:
    quiet = [replace(record("nothing", [], []), key=f"nothing:{i}:0") for i in range(1, 50)]
    false = record("nothing", [], [said("gravity")])
    found = row([*quiet, false], "nothing hidden: an effect")
    assert (found.value, found.count, found.met) == ("2.0%", 50, True)
    assert found.failed == ["nothing:0:0"]
    assert "said gravity 0.99" in failures([found], [false])
    assert row([false], "nothing hidden: an effect").met is False


@pytest.mark.parametrize(
    ("truth", "named", "wrong"),
    [
        (["gravity"], [said("clamp_angle")], True),
        (["gravity"], [said("clamp_angle", 0.9)], False),
        (["gravity"], [said("clamp_angle", 0.99, "gravity")], False),
        (["gravity"], [said("gravity")], False),
        (["gravity"], [], False),
        (["gravity", "force_drift"], [said("gravity")], False),
        (["gravity", "force_drift"], [said("clamp_angle")], True),
        ([], [said("clamp_angle")], True),
    ],
)
def test_confidently_wrong_is_a_single_sure_name_that_is_not_true(
    truth: list[str], named: list[Name], wrong: bool
) -> None:
    assert confidently_wrong(record("other_form", [hid(t) for t in truth], named)) is wrong


def test_a_name_beside_an_unknown_effect_is_no_exact_answer() -> None:
    beside = Unseen("eibm", "long", "s", 20.0)
    one = record("other_form", [hid("gravity")], [said("gravity")], unknown=beside)
    assert row([one], "other form, d >= 8: exactly").value == "0.0%"
    assert row([replace(one, unknown=None)], "other form, d >= 8: exactly").value == "100.0%"


def test_what_looks_like_another_effect_counts_for_its_class_alone() -> None:
    close = record("own_form", [hid("force_offset")], [said("surface_tension")])
    close = replace(close, near={"surface_tension": 3.0})
    assert row([close], "other form, d >= 8: exactly").count == 0
    assert row([close], "one that looks like others").value == "100.0%"
    far = replace(close, named=[said("gravity")])
    assert row([far], "one that looks like others").value == "0.0%"


def test_effects_that_can_hardly_be_seen_do_not_count() -> None:
    weak = record("other_form", [hid("gravity", 7.9)], [])
    assert row([weak], "other form, d >= 8: truth in").count == 0


def test_after_a_further_measurement_the_truth_is_wanted_or_the_class_that_is_left() -> None:
    made = Further("turned_over", ["clamp_angle"], ["clamp_angle", "gravity"], 1.0, 9.0)
    plain = replace(record("ambiguous", [hid("gravity")], [said("gravity")]), further=made)
    near = {"clamp_angle": 2.0}
    wrong = [
        replace(plain, named=[said("clamp_angle")], key="another"),
        replace(
            plain,
            named=[said("gravity", 0.7, "clamp_angle")],
            verdict="indistinguishable",
            key="class, though clear",
        ),
        replace(plain, named=[said("clamp_angle")], near=near, key="without the truth"),
        replace(plain, named=[], verdict="nothing_missing", key="nothing"),
    ]
    right = [
        plain,
        replace(plain, near=near, named=[said("clamp_angle", 0.6, "gravity")]),
        replace(plain, named=[said("gravity", 0.9, "clamp_angle")], key="named, next to another"),
    ]
    unasked = replace(plain, further=None, named=[said("clamp_angle")])
    found = row([*wrong, *right, unasked], "ambiguous, after")
    assert found.count == 7
    assert found.failed == [r.key for r in wrong]
    clear = row([*wrong, *right, unasked], "the same, where it leaves")
    assert (clear.count, clear.failed) == (5, [wrong[0].key, wrong[1].key, wrong[3].key])
    assert "after turned_over (before: clamp_angle, gravity, next 1.0)" in failures([found], wrong)


def test_unknown_is_asked_for_only_where_the_catalogue_imitates_it_badly() -> None:
    bump = hid("local_eibm", 50.0, place_mm=[22.0, 38.0])
    unknown = Unseen("eibm", "long", "s", 39.0)
    good = record("outside", [bump], [], unknown=unknown, left_tolerant={"gravity": 0.5})
    good = replace(good, verdict="unknown_effect")
    imitated = replace(good, left_tolerant={"gravity": 0.1})
    assert row([good, imitated], "outside the catalogue").count == 1
    assert row([good], "the unknown's location").value == "100.0%"
    assert row([good], "the unknown's place").value == "100.0%"
    away = replace(good, unknown=replace(unknown, peak=41.0))
    assert row([away], "the unknown's place").value == "0.0%"
    short = replace(good, unknown=replace(unknown, configuration="short"))
    assert row([short], "the unknown's place").value == "0.0%"


def test_means_alone_ask_for_the_name_or_for_the_series() -> None:
    seen = record("means_only", [hid("gravity")], [said("gravity")])
    unseen = record("means_only", [hid("charging_lag", 0.5)], [], invisible=["charging_lag"])
    assert means_right(seen)
    assert means_right(unseen)
    assert not means_right(replace(unseen, invisible=[]))
    assert not means_right(replace(seen, named=[], invisible=["gravity"]))


def test_a_gap_that_was_not_closed_counts_as_such_and_noise_is_no_gap() -> None:
    plain = record("realistic", [hid("gravity")], [said("gravity")], closed=0.9, chi2_before=5.0)
    assert row([plain], "left-out gap closed, realistic").value == "90.0%"
    assert row([replace(plain, closed=None)], "left-out gap closed, realistic").value == "0.0%"
    assert row([replace(plain, chi2_before=1.1)], "left-out gap closed, realistic").count == 0


def test_intervals_count_for_the_catalogue_s_form_and_the_sheet_that_has_the_effect() -> None:
    true = hid("surface_tension", parameters={"force_mN": 0.4}, as_in_catalogue=True)
    both = {"short": [0.38, 0.3, 0.45], "long": [0.0, -0.1, 0.1]}
    one = record("own_form", [true], [said("surface_tension", force_mN=both)])
    assert intervals(one) == [("surface_tension.force_mN", True)]
    assert intervals(replace(one, truth=[replace(true, as_in_catalogue=False)])) == []
    assert intervals(replace(one, named=[said("gravity")])) == []


def test_a_larger_suite_has_the_cases_of_a_smaller_one_and_every_form() -> None:
    small, whole = tasks(40), tasks(FULL)
    keys = {t.key: t for t in whole}
    assert len(keys) == len(whole) == FULL
    assert all(keys[t.key] == t for t in small)
    assert len({t.case.seed for t in whole}) == FULL
    assert {t.family for t in small} == {t.family for t in whole}
    hidden = {(h.effect, h.form) for t in whole for h in t.case.hidden}
    assert hidden == {(f.effect, f.form) for e in (*CATALOGUE, *OUTSIDE) for f in forms_of(e)}
    assert {t.exclude[0] for t in whole if t.family == "excluded"} == set(CATALOGUE)
    assert sum(t.family == "nothing" for t in whole) >= 400
    assert {t.case.seed for t in tasks(40, seed=1)}.isdisjoint(t.case.seed for t in whole)


def test_a_record_comes_back_from_its_line_and_a_broken_line_is_no_record(tmp_path: Path) -> None:
    path = tmp_path / "all.jsonl"
    one = record("own_form", [hid("gravity")], [said("gravity", 0.9, "clamp_angle")])
    one = replace(one, further=Further("remount", ["gravity"], ["gravity"], 2.0, 5.0))
    one = replace(one, unknown=Unseen("eibm", "long", "s", 1.0), ranking=[("gravity", 12.5)])
    append(path, [one])
    with path.open("a", encoding="utf-8") as file:
        file.write('{"key": "broken off')
    other = replace(one, key="own_form:1:0")
    append(path, [other])
    assert load(path) == [one, other]
    assert load(tmp_path / "none.jsonl") == []


def test_the_confusion_matrix_and_the_tables_show_each_case_once() -> None:
    cases = [
        record("own_form", [hid("gravity")], [said("gravity")]),
        record("own_form", [hid("gravity")], [said("gravity"), said("force_drift")]),
        record("own_form", [hid("clamp_angle")], []),
    ]
    counts, rows, columns = matrix(cases)
    assert rows == [n for n in CATALOGUE if n in ("gravity", "clamp_angle")]
    assert counts.sum() == 3
    at = {(rows[i], columns[j]) for i, j in np.argwhere(counts)}
    assert at == {("gravity", "gravity"), ("gravity", "several"), ("clamp_angle", "nothing")}
    assert table(scored(cases)).count("\n") == len(scored(cases)) + 1
    answered = [replace(c, baselines={"stlsq": {"named": ["gravity"]}}) for c in cases]
    lines = [x for x in compared(answered).splitlines() if x.startswith("| catalogue's form")]
    assert lines == [
        "| catalogue's form, d >= 8: exactly the truth | 3 | 33% (8% - 75%) | 67% (25% - 92%) |"
    ]
