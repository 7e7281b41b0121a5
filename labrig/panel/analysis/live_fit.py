"""The live fit of a running session: follows the run's messages and publishes result after result.

The fit works in a process of its own with low priority. On the real clock it works only between
runs: what computes beside the pulses makes them late.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

from labrig.panel.analysis.fitted_session import FittedSession
from labrig.panel.live.event_stream import EventStream, Mailbox, Message, Picture
from labrig.panel.live.run_phase import RunPhase
from labrig.panel.live.strip_chart import StripChart


class LiveFit:
    """Follows one stream until it is closed."""

    def __init__(self, data: Path, hidden: Path, stream: EventStream) -> None:
        self._data = data
        self._hidden = hidden
        self._stream = stream
        self._news = threading.Event()
        self._box = RunMailbox(self._news.set)
        self._closed = False
        self._fitted: FittedSession | None = None
        self._phase = RunPhase()
        self._result: dict[str, Any] | None = None
        self._thread = threading.Thread(target=self._follow, name="panel-live-fit", daemon=True)
        self._thread.start()

    def result(self, session: str) -> dict[str, Any] | None:
        """Return the newest result of a session that is running, or has just ended."""
        result = self._result
        return result if result is not None and result["session"] == session else None

    def close(self) -> None:
        """End the process."""
        self._closed = True
        self._news.set()
        self._thread.join(5.0)
        self._end()

    # ---------------------------------------------------------------------------- in our thread

    def _follow(self) -> None:
        self._stream.join(self._box)
        while not self._closed:
            self._news.wait()
            self._news.clear()
            while (mail := self._box.take()) is not None:
                if mail.story is not None:
                    self._phase = RunPhase()
                for message in [*(mail.story or ()), *mail.messages]:
                    self._take(message)
        self._stream.leave(self._box)

    def _take(self, message: Message) -> None:
        kind = message["type"]
        self._phase.take(message)
        if kind == "job":
            self._take_job(message)
        elif self._fitted is not None:
            if kind == "run_started" and self._phase.pulses:
                self._fitted.hold()
            elif kind == "run_stopped":
                self._fitted.run_stopped()
            elif kind == "marked":
                self._fitted.fit()

    def _take_job(self, job: Message) -> None:
        fitted = self._fitted
        if job["kind"] != "run" or job["session"] is None:
            return
        if job["state"] not in ("starting", "going"):
            if fitted is not None and fitted.job == job["id"]:
                fitted.session_ended()
            return
        if fitted is None or fitted.job != job["id"]:
            self._end()
            self._result = None
            session = self._data / job["session"]
            self._fitted = FittedSession(job["id"], session, self._hidden, self._publish)

    def _publish(self, job: str, result: Message) -> None:
        fitted = self._fitted
        if fitted is None or fitted.job != job:
            return
        name = fitted.session.relative_to(self._data).as_posix()
        self._result = {**result, "session": name}
        self._stream.publish_newest({**self._result, "type": "result"})

    def _end(self) -> None:
        if self._fitted is not None:
            self._fitted.end()
            self._fitted = None


class RunMailbox(Mailbox):
    """Messages only: signals and images are nothing for a fit."""

    def put_strip(self, strip: StripChart) -> None:
        """Leave it out."""

    def put_picture(self, picture: Picture) -> None:
        """Leave it out."""
