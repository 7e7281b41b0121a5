"""The process that fits one running session; after a crash it is restarted with the next run."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from labrig.errors import LabrigError
from labrig.panel.analysis.order import AnalysisOrder
from labrig.panel.analysis.process import AnalysisProcess, Message
from labrig.panel.processes import CAN_STEP_BACK

WAIT_S = 5.0
MOST_STARTS = 3


class FittedSession:
    """`publish(job, result)` is called in a thread of our own. The other methods never wait."""

    def __init__(
        self, job: str, session: Path, hidden: Path, publish: Callable[[str, Message], None]
    ) -> None:
        self.job = job
        self.session = session
        self._hidden = hidden
        self._publish = publish
        self._process: AnalysisProcess | None = None
        self._starts = 0
        self._held = False
        self._ended = False
        self._start()

    def fit(self) -> None:
        """Fit what has been measured so far."""
        if self._process is None and not self._ended:
            self._start()
        self._say("fit")

    def run_stopped(self) -> None:
        """Fit, until the next run begins."""
        self._held = False
        process = self._process
        if process is not None:
            process.step_forward()
            process.say("continue")
        self.fit()

    def hold(self) -> None:
        """Wait until the present run is over; what has begun computes after all others."""
        self._held = True
        process = self._process
        if process is not None:
            process.say("hold")
            process.step_back()

    def session_ended(self) -> None:
        """Fit what is left; then the process ends."""
        self._ended = True
        process = self._process
        if process is not None:
            process.step_forward()
        self._say("end")

    def end(self) -> None:
        """End the process at once."""
        self._ended = True
        process = self._process
        if process is not None:
            process.end()

    def _say(self, word: str) -> None:
        process = self._process
        if process is not None:
            process.say(word)

    def _start(self) -> None:
        if self._starts >= MOST_STARTS:
            return
        self._starts += 1
        order = AnalysisOrder(kind="live", session=str(self.session))
        with suppress(LabrigError):  # no result then; the run is what counts
            self._process = process = AnalysisProcess(order, self._hidden)
            if not CAN_STEP_BACK:
                process.lower()
            if self._held:
                self.hold()
            threading.Thread(
                target=self._hear, args=(process,), name="panel-live-results", daemon=True
            ).start()

    def _hear(self, process: AnalysisProcess) -> None:
        while True:
            try:
                message = process.message(WAIT_S)
            except queue.Empty:
                continue
            if message is None:
                break
            if message["type"] == "result":
                self._publish(self.job, message)
        if self._process is process:
            self._process = None
        process.end()
