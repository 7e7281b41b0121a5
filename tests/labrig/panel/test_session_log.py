"""The log of a session, as its page shows it."""

from __future__ import annotations

from types import SimpleNamespace

from labrig.panel.pages.session import log_of
from labrig.session.reading.session import LoggedEvent


def test_no_line_of_the_log_is_empty() -> None:
    events = [
        LoggedEvent(time_s=1.5, kind="started", run=-1, reading=-1, subject="", text=""),
        LoggedEvent(time_s=2.0, kind="prompt", run=0, reading=-1, subject="move", text="to 5 mm"),
    ]
    lines = log_of(SimpleNamespace(began_s=1.5, events=events))  # type: ignore[arg-type]
    assert [line["text"] for line in lines] == ["started", "move to 5 mm"]
