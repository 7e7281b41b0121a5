"""The live fit's process: after each position of a running session, B and EIBM so far.

Its input says `fit` when a run is over, `hold` and `continue` around a run that it must not
disturb, and `end` after the last run. It stays for the whole session, so that what a fit needs is
loaded once.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TextIO

from labrig.analysis.results import Convergence, converging, result_of
from labrig.analysis.running import RunningAnalysis
from labrig.errors import BadInputError
from labrig.panel.analysis.order import AnalysisOrder
from labrig.panel.processes import end_with_children
from labrig.report.data.fitted import fit_what_can_be

if TYPE_CHECKING:
    from model import Measurements

TRIES = 10
AGAIN_S = 0.5  # a run that has ended is measured when the file has settled


class Sink(Protocol):
    """Where results go."""

    def send(self, kind: str, **fields: object) -> None:
        """Send one message."""


def follow(order: AnalysisOrder, source: TextIO, sink: Sink) -> None:
    """Send a result after each run, until the input says `end` or ends."""
    words = Words(source)
    path = Path(order.session)
    analysis = RunningAnalysis(path, words.wait_while_held)
    live_fit = LiveResult(path.name)
    while words.wait_for_fit():
        for _ in range(TRIES):
            found = _send_all(analysis, live_fit, words, sink)
            if found or words.ended.wait(AGAIN_S):
                break
    _send_all(analysis, live_fit, words, sink)  # the last run may have ended with the session


def _send_all(analysis: RunningAnalysis, live_fit: LiveResult, words: Words, sink: Sink) -> int:
    """Send a result for each run that is new, and return their number."""
    count = 0
    try:
        words.wait_while_held()  # a session is not even read while a run is on
        while (measurements := analysis.measure_next()) is not None:
            words.wait_while_held()
            sink.send("result", **live_fit.of(measurements))
            count += 1
    except BadInputError:  # the file is being closed at this moment; the next try shows more
        return count
    return count


class LiveResult:
    """The result of the measurements so far, with the history of B and EIBM."""

    def __init__(self, session: str) -> None:
        self._session = session
        self._convergence: Convergence = {}
        self._conditions = 0

    def of(self, measurements: Measurements) -> dict[str, Any]:
        """Return what `labrig.analysis.results.result_of` returns."""
        fitted = fit_what_can_be(measurements).fit
        if len(measurements.conditions) == self._conditions:  # a run that is marked now
            self._convergence = {}
        self._conditions = len(measurements.conditions)
        self._convergence = converging(measurements, self._convergence, whole=fitted)
        return result_of(
            measurements, session=self._session, fitted=fitted, convergence=self._convergence
        )


class Words:
    """What the panel says, heard in a thread of its own."""

    def __init__(self, source: TextIO) -> None:
        self._source = source
        self._fit = threading.Event()
        self._free = threading.Event()
        self._free.set()
        self.ended = threading.Event()
        threading.Thread(target=self._hear, name="live-fit-words", daemon=True).start()

    def wait_for_fit(self) -> bool:
        """Wait until there is something to fit; False: there will be nothing more."""
        self._fit.wait()
        self._fit.clear()
        return not self.ended.is_set()

    def wait_while_held(self) -> None:
        """Wait while the run must not be disturbed."""
        self._free.wait()

    def _hear(self) -> None:
        for line in self._source:
            word = line.strip()
            if word == "fit":
                self._fit.set()
            elif word == "hold":
                self._free.clear()
            elif word == "continue":
                self._free.set()
            elif word == "end":
                break
        else:
            end_with_children(os.getpid())  # the panel has gone
        self.ended.set()
        self._free.set()
        self._fit.set()
