"""A run that the guard has ended says so to whoever looks next."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from labrig.errors import BadInputError
from labrig.experiment.watchdog import watched
from labrig.session import SessionWriter, open_session, recover, verify
from labrig.session.reading.guard_report import guard_report_path, read_guard_report
from labrig.session.recording.journal import journal_path
from protocols.execution.events import OutputState
from tests.cases import few
from tests.labrig.session.session_recording import session_events, settings, small_schedule

SAFE = {"why": "the program hangs", "state": "safe", "read_back_V": 0.0004, "failures": []}
UNKNOWN = {**SAFE, "state": "unknown", "read_back_V": None, "failures": ["no connection"]}


@pytest.fixture
def cut(tmp_path):
    """A session whose program has come to nothing after a few events."""
    live, path = tmp_path / "live.h5", tmp_path / "s.h5"
    schedule = small_schedule()
    with SessionWriter(live, **settings(schedule)) as writer:
        for event, _ in zip(session_events(schedule), range(6), strict=False):
            writer.handle(event)
        path.write_bytes(live.read_bytes())
        journal_path(path).write_bytes(journal_path(live).read_bytes())
    return path


@pytest.mark.slow
def test_whoever_opens_it_is_told_that_the_guard_has_written_0_V(cut):
    guard_report_path(cut).write_text(json.dumps(SAFE))
    told = r"output guard has ended this run \(the program hangs\).*0 V written and read back as"
    with pytest.raises(BadInputError, match=told) as caught:
        open_session(cut)
    assert f"labrig recover {cut}" in str(caught.value)
    assert "the program hangs" in verify(cut)[0].found


@pytest.mark.slow
def test_an_output_that_the_guard_could_not_make_safe_is_told_as_such(cut):
    guard_report_path(cut).write_text(json.dumps(UNKNOWN))
    with pytest.raises(BadInputError, match=r"NOT KNOWN TO BE SAFE .*switch the amplifier off"):
        open_session(cut)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("report", "state"), few([(SAFE, OutputState.SAFE), (UNKNOWN, OutputState.UNKNOWN)])
)
def test_what_is_recovered_keeps_what_the_guard_has_found(cut, report, state):
    guard_report_path(cut).write_text(json.dumps(report))
    with open_session(recover(cut).output) as session:
        assert session.output_state is state
        assert "The output guard has ended this run (the program hangs)" in session.reason


@pytest.mark.slow
def test_recovered_in_place_the_session_says_it_itself(cut):
    guard_report_path(cut).write_text(json.dumps(SAFE))
    recover(cut, in_place=True)
    assert not guard_report_path(cut).exists()


@pytest.mark.slow
@pytest.mark.parametrize("text", few(["", '{"why": "the prog', "[]", '{"state": "fine"}', "null"]))
def test_a_report_that_is_not_whole_is_none(cut, text):
    guard_report_path(cut).write_text(text)
    assert read_guard_report(cut) is None
    with pytest.raises(BadInputError, match="recorded right now, or its recording was cut short"):
        open_session(cut)


def test_what_was_said_of_an_earlier_session_of_that_name_is_not_said_of_a_new_one(tmp_path):
    session = tmp_path / "s.h5"
    guard_report_path(session).write_text(json.dumps(SAFE))
    simulated = SimpleNamespace(config=SimpleNamespace(is_simulated=True), interlock=None)
    with watched(simulated, session):
        assert read_guard_report(session) is None
