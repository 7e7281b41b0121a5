"""A computer's clock that is set during the work, or has never been set."""

from __future__ import annotations

import datetime as dt
import os
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from labrig.experiment.resume import Resumption
from labrig.exports.choice import export
from labrig.files import write_zip
from labrig.session import SessionWriter, open_session
from protocols.execution import events as ev
from tests.labrig.session.session_recording import session_events, settings, small_schedule
from tests.labrig.test_exports import read_documents

BEGAN_S = 100.0  # of `session_events`
NOW_S = 5000.0


def recorded(
    path: Path, started: str, ended: str = "", *, after: ev.Event | None = None
) -> tuple[float, float]:
    """Record a session with these times of day; clock times of its first and last event.

    `after`: an event before all others, as of a session that was resumed.
    """
    schedule = small_schedule()
    events = [*([] if after is None else [after]), *session_events(schedule)]
    with SessionWriter(path, **settings(schedule)) as writer:
        for event in events:
            if isinstance(event, ev.SessionStarted):
                event = replace(event, wall=started)
            if isinstance(event, ev.SessionStopped):
                event = replace(event, wall=ended)
            writer.handle(event)
    return events[0].time_s, events[-1].time_s


def minutes_ago(minutes: float) -> str:
    return (dt.datetime.now(dt.UTC) - dt.timedelta(minutes=minutes)).isoformat()


def copied_times_s(path: Path) -> list[float]:
    """Return the times of all that is copied where the session is resumed at `NOW_S`."""
    found = list[ev.Event]()
    with open_session(path) as session:
        Resumption(session).publish(found.append, NOW_S)
    return [event.time_s for event in found]


@pytest.mark.parametrize(
    "started_min_ago",
    [-60.0, 0.0, None],
    ids=["set back since", "set back by less than the session took", "not set then"],
)
def test_what_a_resumed_session_copies_is_just_over_where_the_clock_cannot_say_when_it_was(
    tmp_path: Path, started_min_ago: float | None
) -> None:
    never_set = "1970-01-01T00:00:05+00:00"
    started = never_set if started_min_ago is None else minutes_ago(started_min_ago)
    began_s, ended_s = recorded(tmp_path / "s.h5", started)
    times_s = copied_times_s(tmp_path / "s.h5")
    assert max(times_s) <= NOW_S
    assert min(times_s) == pytest.approx(NOW_S - (ended_s - began_s))


def test_the_runs_of_a_session_that_was_resumed_keep_their_time_when_it_is_resumed_again(
    tmp_path: Path,
) -> None:
    """Its clock has the first session's start, its time of day that of the second."""
    earlier = ev.Resumed(BEGAN_S - 600.0, "of the first", ())
    recorded(tmp_path / "s.h5", minutes_ago(20.0), after=earlier)
    times_s = copied_times_s(tmp_path / "s.h5")
    assert min(times_s) == pytest.approx(NOW_S - 20 * 60.0 - 600.0, abs=10.0)


@pytest.mark.slow
def test_documents_are_dated_in_their_order_where_the_clock_was_set_back(tmp_path: Path) -> None:
    began_s, ended_s = recorded(
        tmp_path / "s.h5", "2026-10-25T01:59:00+00:00", "2026-10-25T01:00:30+00:00"
    )
    (path,) = export(tmp_path / "s.h5", tmp_path / "out", "bluesky")
    found = read_documents(path)
    times_s = [content["time"] for name, content in found if name in ("start", "event", "stop")]
    assert times_s == sorted(times_s)
    assert times_s[-1] - times_s[0] == pytest.approx(ended_s - began_s)


def test_files_from_before_1980_are_packed(tmp_path: Path) -> None:
    """A computer without a battery for its clock begins in 1970, the times of a zip in 1980."""
    figure = tmp_path / "figure.svg"
    figure.write_text("drawn")
    os.utime(figure, (100.0, 100.0))
    write_zip(tmp_path / "figures.zip", {figure: "in/figure.svg"})
    assert zipfile.ZipFile(tmp_path / "figures.zip").read("in/figure.svg") == b"drawn"
