"""Make the output safe, whatever the boards do: attempts that hang are left behind, not waited for.

All of it has one deadline: after `REPORT_S` the guard reports what it knows, so that a program that
waits can end; then it goes on, for nobody else may be left who could.
"""

from __future__ import annotations

import contextlib
import json
import sys
import threading
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from drivers.boards import OutputRescue
from drivers.guard.settings import GuardSettings
from drivers.interfaces import Clock
from drivers.safe_shutdown import NOT_SAFE, Safety, SafetyReport, attempt, report_of

TELL_S = 1.0  # without 0 V the operator is told so
REPORT_S = 7.0  # with boards that refuse, or do not answer; then it is reported
LONGEST_S = 30.0  # and tried on for so long
HANGS_S = 2.5  # an attempt that takes longer is left behind, and another one begun beside it
_BETWEEN_TRIES_S = 0.2
_LOOK_S = 0.02
_PATIENCE_S = 3.0


class _Attempt:
    """One attempt, in a thread of its own."""

    def __init__(self, begun_s: float, work: Callable[[], SafetyReport]) -> None:
        self.begun_s = begun_s
        self.report: SafetyReport | None = None
        self._done = threading.Event()

        def run() -> None:
            self.report = report_of(work)
            self._done.set()

        threading.Thread(target=run, name="rescue", daemon=True).start()

    def wait(self, seconds: float) -> bool:
        """Return whether it has come to an end."""
        return self._done.wait(seconds)

    @property
    def is_safe(self) -> bool:
        """Whether it has made the output safe by now."""
        return self.report is not None and self.report.is_safe


class Rescuer:
    """Makes the output safe and says so. Used once."""

    def __init__(
        self,
        settings: GuardSettings,
        rescue: OutputRescue,
        another: Callable[[], OutputRescue],
        clock: Clock,
        send: Callable[[str], None],
    ) -> None:
        """`another` makes a further rescue, not open; `send` gets each report for the program."""
        self._settings = settings
        self._rescue = rescue
        self._another = another
        self._clock = clock
        self._send = send
        self._attempts: list[_Attempt] = []
        self._reported = False

    def act(
        self, on_held: Callable[[], None], why_of: Callable[[SafetyReport, float], str]
    ) -> SafetyReport:
        """Try until 0 V is read back, or for `LONGEST_S`. Nothing that boards' code raises ends it.

        `why_of` says why it acts, from the first report and the time that this took.
        """
        clock, began_s = self._clock, self._clock.now()
        self._begin(lambda: self._rescue.make_safe(_PATIENCE_S, on_held))
        report, why, told = self._hangs(), "", False
        while clock.now() < began_s + LONGEST_S:
            ended = self._attempts[-1].wait(_LOOK_S)
            took_s = clock.now() - began_s
            report = self._last(ended) or report
            why = why or (why_of(report, took_s) if ended or took_s > TELL_S else "")
            if report.is_safe:
                break
            if not told and took_s > TELL_S:
                told = True
                _say(f"{why}; {NOT_SAFE} yet: switch the amplifier off by hand; it keeps trying")
            if not self._reported and took_s > REPORT_S:
                self._tell(why, report, more="; the guard keeps trying")
                self._reported = True
            self._go_on(ended, on_held)
        self._tell(why or why_of(report, clock.now() - began_s), report)
        return report

    def _begin(self, work: Callable[[], SafetyReport]) -> None:
        self._attempts.append(_Attempt(self._clock.now(), work))

    def _last(self, ended: bool) -> SafetyReport | None:
        """Return the report of an attempt that was successful, else of the last that has ended."""
        safe = [each.report for each in self._attempts if each.is_safe]
        if safe:
            return safe[0]
        return self._attempts[-1].report if ended else None

    def _go_on(self, ended: bool, on_held: Callable[[], None]) -> None:
        """Begin another attempt when the last one has failed, or hangs."""
        if ended:
            if len(self._attempts) == 1:  # a later one lets go of its own
                attempt([], self._rescue.close)
            self._clock.sleep_until(self._clock.now() + _BETWEEN_TRIES_S)
        elif self._clock.now() < self._attempts[-1].begun_s + HANGS_S:
            return

        def again() -> SafetyReport:
            rescue = self._another()
            rescue.open()
            try:
                return rescue.make_safe(_PATIENCE_S, on_held)
            finally:
                attempt([], rescue.close)

        self._begin(again)

    def _hangs(self) -> SafetyReport:
        text = f"the boards have not answered for {HANGS_S:g} s"
        return SafetyReport(Safety.UNKNOWN, None, (text,))

    def _tell(self, why: str, report: SafetyReport, more: str = "") -> None:
        """Say how it went to the program, and where somebody may look who outlives it."""
        facts = json.dumps({"why": why, **asdict(report)}, default=float)  # numpy's numbers, too
        _say(f"{why}; {report.text}{more}")
        path = self._settings.report_path
        # A program that has its report and has ended by itself has removed the file: leave it so.
        if path is not None and (not self._reported or Path(path).exists()):
            with contextlib.suppress(OSError):
                Path(path).write_text(facts, encoding="utf-8")
        self._send(facts)


def _say(text: str) -> None:
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.write(f"labrig's output guard: {text}\n")
        sys.stderr.flush()
