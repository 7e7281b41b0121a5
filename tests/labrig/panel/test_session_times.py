"""Times of a session as people read them: since its start, by its own clock."""

from __future__ import annotations

import pytest

from labrig.library import read_entry
from labrig.panel.pages.session import log_of
from labrig.report.tables.overview import overview
from labrig.session import open_session
from tests.end_to_end.small_rig import ONE_POSITION, make_rig, run_rig

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    folder = make_rig(tmp_path_factory.mktemp("times") / "rig", ONE_POSITION + 'mode = "paper"\n')
    return run_rig(folder)


@pytest.mark.thorough
def test_the_log_of_a_session_begins_at_0(path):
    with open_session(path) as session:
        assert session.events[0].time_s > 1.0  # by a clock whose zero means nothing
        log = log_of(session)
        shown = overview(session).log
    assert log[0]["time_s"] == 0.0
    assert log[0]["kind"] == "started"
    times_s = [line["time_s"] for line in log]
    assert times_s == sorted(times_s)
    assert times_s[-1] < 60.0
    assert shown[0][0] == "0.000"


def test_the_length_of_a_session_is_that_of_its_own_clock_which_is_said_to_be_virtual(path):
    entry = read_entry(path, path.name)
    with open_session(path) as session:
        assert session.clock == "virtual"
        run = session.runs[0].planned.duration_s
        own_s = session.events[-1].time_s - session.events[0].time_s
    assert entry.clock == "virtual"
    assert entry.duration_s == pytest.approx(own_s)
    assert entry.duration_s > run
