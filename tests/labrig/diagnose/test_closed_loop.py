"""Measure, diagnose, measure what separates: bounded, and only as long as it helps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import model.discrepancy
from labrig.analysis.together import together
from labrig.cli.follow import FOLLOWS
from labrig.errors import BadInputError, ExitCode
from labrig.experiment.next_measurement.closed_loop import MOST_ROUNDS, closed_loop
from labrig.session import load_measurements, open_session
from model.effects import effect
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig
from tests.labrig.diagnose import made
from tests.labrig.report_data import measure


class Pretended:
    """A rig whose diagnoses are made by hand."""

    def __init__(self, *verdicts, agrees=True, code=ExitCode.DONE) -> None:
        self.verdicts, self.agrees, self.code = list(verdicts), agrees, code
        self.asked, self.measured = [], []

    def diagnose(self, sessions):
        self.asked.append(list(sessions))
        return self.verdicts.pop(0) if len(self.verdicts) > 1 else self.verdicts[0]

    def agree(self, proposed):
        return self.agrees

    def measure(self, proposed, sessions, output):
        self.measured.append((proposed.extra, output))
        return self.code


def proposing(extra):
    one = made.indistinguishable()
    return replace(one, next_measurement=replace(one.next_measurement, extra=extra))


FIRST = Path("first.h5")


@pytest.mark.slow
def test_a_class_is_measured_further_until_one_is_named():
    rig = Pretended(proposing("free_shapes"), proposing("remount"), made.found())
    ended = closed_loop(FIRST, rig, lambda _: None)
    assert [extra for extra, _ in rig.measured] == ["free_shapes", "remount"]
    assert rig.asked[-1] == [FIRST, Path("first-2.h5"), Path("first-3.h5")]
    assert ended.diagnosis.verdict == "effect_named"
    assert ended.code is ExitCode.DONE


@pytest.mark.slow
@pytest.mark.parametrize("make", [made.found, made.nothing_missing, made.unknown, made.cannot_tell])
def test_nothing_is_measured_where_the_verdict_is_no_class(make):
    rig = Pretended(make())
    assert closed_loop(FIRST, rig, lambda _: None).sessions == (FIRST,)
    assert rig.measured == []


@pytest.mark.slow
def test_it_ends_when_nothing_on_the_menu_helps():
    rig = Pretended(replace(made.indistinguishable(), next_measurement=None))
    assert "nothing on the menu" in closed_loop(FIRST, rig, lambda _: None).why
    assert rig.measured == []


@pytest.mark.slow
def test_what_hardly_helps_is_not_measured():
    one = proposing("free_shapes")
    little = replace(one.next_measurement, separation=1.3, expected=1.6)
    rig = Pretended(replace(one, next_measurement=little))
    why = closed_loop(FIRST, rig, lambda _: None).why
    assert "nothing on the menu" in why
    for name in (one.effects[0].name, *one.effects[0].confusable_with):
        assert effect(name).isolates.rstrip(".") in why  # what does, though nobody proposes it
    assert rig.measured == []


def test_the_same_is_measured_again_where_that_helps_most():
    rig = Pretended(proposing("free_shapes"), proposing("free_shapes"), made.found())
    closed_loop(FIRST, rig, lambda _: None)
    assert [extra for extra, _ in rig.measured] == ["free_shapes", "free_shapes"]


def test_it_ends_after_a_few_rounds_whatever_comes():
    rig = Pretended(*(proposing(f"extra {i}") for i in range(20)))
    closed_loop(FIRST, rig, lambda _: None)
    assert len(rig.measured) == MOST_ROUNDS


def test_nothing_is_measured_that_the_operator_declines():
    rig = Pretended(proposing("free_shapes"), agrees=False)
    assert "not made" in closed_loop(FIRST, rig, lambda _: None).why
    assert rig.measured == []


def test_a_measurement_that_is_stopped_ends_it_with_its_code():
    rig = Pretended(proposing("free_shapes"), code=ExitCode.STOPPED)
    ended = closed_loop(FIRST, rig, lambda _: None)
    assert ended.code is ExitCode.STOPPED
    assert ended.sessions == (FIRST,)


def test_a_session_that_is_there_already_is_not_overwritten(tmp_path):
    (tmp_path / "first-2.h5").touch()
    rig = Pretended(proposing("free_shapes"), made.found())
    closed_loop(tmp_path / "first.h5", rig, lambda _: None)
    assert rig.measured == [("free_shapes", tmp_path / "first-3.h5")]


# -- several sessions as one


def test_sessions_taken_together_are_mountings_of_their_own():
    one = measure("long")
    both = together([(Path("a.h5"), one), (Path("b.h5"), one)])
    assert len(both.conditions) == 2 * len(one.conditions)
    assert {c.mounting for c in both.conditions} == {0, 1}
    assert {c.session for c in both.conditions} == {1, 2}
    assert {s.mounting for s in both.series} == {0, 1}
    keys = {(c.configuration, c.position_m, c.voltage_V, c.mounting) for c in both.conditions}
    assert len(keys) == len(both.conditions)
    three = together([(Path("a.h5"), both), (Path("c.h5"), one)])
    assert {c.mounting for c in three.conditions} == {0, 1, 2}
    assert {c.session for c in three.conditions} == {1, 2, 3}


def test_times_of_the_session_go_on_from_one_to_the_next():
    one = measure("long")
    timed = replace(
        one,
        conditions=tuple(
            replace(c, readings=tuple(replace(r, session_s=r.time_s) for r in c.readings))
            for c in one.conditions
        ),
    )
    both = together([(Path("a.h5"), timed), (Path("b.h5"), timed)])
    first, second = ([r.session_s for c in both.conditions for r in c.readings if c.mounting == m]
                     for m in (0, 1))  # fmt: skip
    assert min(second) > max(first)


@pytest.mark.slow
def test_sessions_of_different_sheets_are_not_taken_together():
    one, other = measure("long"), measure("long")
    sheet = replace(other.sheets["long"], free_length_m=0.06)
    with pytest.raises(BadInputError, match="only sessions of the same sheet"):
        together([(Path("a.h5"), one), (Path("b.h5"), replace(other, sheets={"long": sheet}))])


# -- at the (simulated) rig


@pytest.mark.slow
def test_run_and_diagnose_measures_the_proposed_session_and_links_it(tmp_path, monkeypatch, capsys):
    verdicts = [proposing("free_shapes"), made.found()]
    seen = []

    def diagnose(measurements, options=None, progress=None):
        seen.append(measurements)
        return verdicts[len(seen) - 1]

    monkeypatch.setattr(model.discrepancy, "diagnose", diagnose)
    make_rig(tmp_path, ONE_POSITION + 'mode = "paper"\n')
    files = [tmp_path / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    first = tmp_path / "first.h5"
    assert labrig("run", *files, "-o", first, "--yes", "--diagnose") == 0
    out = capsys.readouterr().out
    second = tmp_path / "first-2.h5"
    with open_session(first) as one, open_session(second) as two:
        assert two.texts[FOLLOWS] == one.identifier
        assert FOLLOWS not in one.texts
        assert [r.planned.purpose.value for r in two.runs] == ["free_shape"]
    assert len(seen[1].conditions) > len(seen[0].conditions)
    assert {c.position_m for c in load_measurements(second).conditions} == {None}
    assert "Ended with 2 sessions: the data allow a verdict." in out
