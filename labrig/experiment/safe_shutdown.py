"""Make the output safe at the end of a run, however it ends."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

from drivers.safe_shutdown import NOT_SAFE, SafetyReport, in_time, make_safe
from labrig.experiment.rig.rig import DRIVE, Rig
from labrig.experiment.watchdog import NoWatchdog, Watchdog

# Boards that do not answer end a run within 10 s of their last answer. It takes up to 2 s to notice
# that, here is the rest but for closing the files: our own devices have their time
# (`drivers.safe_shutdown`), the boards are let go of, the guard acts and reports. Where no guard
# can act, or it has died, our own devices are tried again until the end of that time.
_RELEASE_S = 0.3
_ALL_S = 6.0
_LEAST_ACT_S = 1.0  # a guard has so long, however late it is asked
_NOT_YET = f"{NOT_SAFE} yet: switch the amplifier off by hand; labrig keeps trying"


class SafeShutdown:
    """Makes an opened rig safe: by its own devices, else by the watchdog."""

    def __init__(self, rig: Rig, on_begin: Callable[[], object] = lambda: None) -> None:
        """`on_begin` is called whenever it begins; it must not raise."""
        self._rig = rig
        self._on_begin = on_begin
        self.watchdog: Watchdog = NoWatchdog()  # set once there is one
        self.report: SafetyReport | None = None  # the last one
        self.tell: Callable[[str], object] = lambda _text: None  # the operator, while it tries on
        self._is_told = False

    def make_safe(self) -> SafetyReport:
        """Write 0 V and read it back; return what is known of the output. Never raises."""
        self._on_begin()
        end_s, self._is_told = self._rig.clock.now() + _ALL_S, False
        report = self._by_our_devices()
        if not report.is_safe:
            self._not_yet()
            others = self.watchdog.can_act
            rest = self._by_the_watchdog if others else self._at_last
            report = rest(report, end_s)
        self.report = report
        return report

    def _by_our_devices(self, until_s: float | None = None) -> SafetyReport:
        rig = self._rig
        below_V = rig.config.limits.safe_below_V
        return make_safe(
            rig.output, rig.read_back, rig.clock, DRIVE, below_V, until_s, not_yet=self._not_yet
        )

    def _not_yet(self) -> None:
        """Tell the operator, once, that the output may be live."""
        if not self._is_told:
            self._is_told = True
            with suppress(Exception):  # whoever is told may have failed before
                self.tell(_NOT_YET)

    def _at_last(self, own: SafetyReport, until_s: float) -> SafetyReport:
        """Try our own devices until the deadline: nobody else is there who would."""
        found = self._by_our_devices(until_s)
        if not found.is_safe:
            self._let_go()  # closing would ask the boards once more, and wait for each answer
        return replace(found, failures=tuple(dict.fromkeys((*own.failures, *found.failures))))

    def _let_go(self) -> None:
        """Release the boards as they are."""
        rig = self._rig
        for release in (rig.output.abandon, rig.read_back.close, rig.boards.close):
            with suppress(Exception, SystemExit):  # of other distributions' boards, too
                in_time(rig.clock, "releasing the boards", release, _RELEASE_S)

    def _by_the_watchdog(self, own: SafetyReport, until_s: float) -> SafetyReport:
        """Have the guard do it on its own connection, after ours has released the boards."""
        self._let_go()
        found = self.watchdog.act(max(_LEAST_ACT_S, until_s - self._rig.clock.now()))
        if found is None:
            return own
        return SafetyReport(found.state, found.read_back_V, own.failures + found.failures)


@contextmanager
def safe_shutdown(
    rig: Rig, on_begin: Callable[[], object] = lambda: None
) -> Iterator[SafeShutdown]:
    """End the block, and the program within it, with `make_safe`, whatever ends them."""
    shutdown = SafeShutdown(rig, on_begin)
    atexit.register(shutdown.make_safe)
    try:
        yield shutdown
    finally:
        atexit.unregister(shutdown.make_safe)
        if shutdown.report is None:
            shutdown.make_safe()
