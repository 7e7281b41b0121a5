"""The one way out of a run: however it ends, the output is made safe here."""

from __future__ import annotations

import atexit
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from drivers.interfaces import DeviceError
from drivers.safe_shutdown import DEVICE_S, SafetyReport, in_time, make_safe
from labrig.experiment.rig import DRIVE, Rig
from labrig.experiment.watchdog import NoWatchdog, Watchdog


class SafeShutdown:
    """Makes an opened rig safe: by its own devices, else by whoever watches over the run."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self.watch: Watchdog = NoWatchdog()  # set once somebody watches
        self.report: SafetyReport | None = None  # the last one

    def make_safe(self) -> SafetyReport:
        """Never raises."""
        rig = self._rig
        below_V = rig.config.limits.safe_below_V
        report = make_safe(rig.output, rig.read_back, rig.clock, DRIVE, below_V)
        if not report.is_safe:
            report = self._by_the_watch(report)
        self.report = report
        return report

    def _by_the_watch(self, own: SafetyReport) -> SafetyReport:
        """The guard has a connection of its own; ours must let go of the boards first."""
        if isinstance(self.watch, NoWatchdog):
            return own
        rig = self._rig
        for let_go in (rig.output.abandon, rig.read_back.close, rig.boards.close):
            with suppress(DeviceError):
                in_time(rig.clock, "letting go of the boards", let_go, DEVICE_S)
        found = self.watch.act()
        if found is None:
            return own
        return SafetyReport(found.state, found.read_back_V, own.failures + found.failures)


@contextmanager
def safe_shutdown(rig: Rig) -> Iterator[SafeShutdown]:
    """Whatever ends the block, or the program within it, ends with `make_safe`."""
    way = SafeShutdown(rig)
    atexit.register(way.make_safe)
    try:
        yield way
    finally:
        atexit.unregister(way.make_safe)
        if way.report is None:
            way.make_safe()
