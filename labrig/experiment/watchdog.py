"""The watchdogs of a run while the output is energised: the guard, and the rig's interlock."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol

from drivers.guard import Guard, GuardSettings
from drivers.guard.settings import AT_ZERO_LIMIT_S
from drivers.interfaces import DeviceError, Interlock
from drivers.safe_shutdown import SafetyReport
from drivers.watch import WatchLink, read_token
from labrig.errors import NotReadyError
from labrig.experiment.rig.rig import Rig
from labrig.experiment.safety import output_place
from labrig.session.reading.guard_report import forget_guard_report, guard_report_path

_GRACE_S = 1.0  # the schedule was checked against the limit; the guard acts when it is passed


class Watchdog(Protocol):
    """Watches over the process while the output is energised."""

    @property
    def can_act(self) -> bool:
        """Whether it is there to make the output safe, or has done so."""

    def new_run(self) -> None:
        """Note that a run begins, at 0 V."""

    def run_over(self) -> None:
        """Note that it has ended: nothing beats until the next one."""

    def beat(self) -> None:
        """Note that the working loop is alive; called at least every 50 ms during a run."""

    def energised(self, on: bool) -> None:
        """Note that a voltage other than 0 is about to be written, or that 0 V was confirmed."""

    def act(self, timeout_s: float) -> SafetyReport | None:
        """Make the output safe in our place, our devices being released; None: it cannot.

        Returns after `timeout_s` at the latest, also where it still tries.
        """


class NoWatchdog:
    """Does nothing: a simulated output ends with its program."""

    can_act = False

    def new_run(self) -> None:
        """See `Watchdog.new_run`."""

    def run_over(self) -> None:
        """See `Watchdog.run_over`."""

    def beat(self) -> None:
        """See `Watchdog.beat`."""

    def energised(self, on: bool) -> None:
        """See `Watchdog.energised`."""

    def act(self, timeout_s: float) -> SafetyReport | None:  # noqa: ARG002
        """See `Watchdog.act`."""
        return None


class InterlockWatchdog:
    """Another watchdog, and a line that is toggled with each of its beats."""

    def __init__(self, watch: Watchdog, interlock: Interlock) -> None:
        self._watch = watch
        self._interlock = interlock
        self.new_run = watch.new_run
        self.run_over = watch.run_over
        self.energised = watch.energised
        self.act = watch.act

    @property
    def can_act(self) -> bool:
        """See `Watchdog.can_act`."""
        return self._watch.can_act

    def beat(self) -> None:
        """See `Watchdog.beat`."""
        self._watch.beat()
        self._interlock.beat()


class FarWatchdog:
    """Another watchdog, and the watch at the boards beside it."""

    def __init__(self, watch: Watchdog, link: WatchLink) -> None:
        self._watch = watch
        self._link = link

    @property
    def can_act(self) -> bool:
        """See `Watchdog.can_act`. The watch acts by itself, whether it is asked or not."""
        return self._watch.can_act

    def new_run(self) -> None:
        """See `Watchdog.new_run`."""
        self._watch.new_run()
        self._link.new_run()

    def run_over(self) -> None:
        """See `Watchdog.run_over`. The watch at the boards looks only while there is a voltage."""
        self._watch.run_over()

    def beat(self) -> None:
        """See `Watchdog.beat`."""
        self._watch.beat()
        self._link.beat()

    def energised(self, on: bool) -> None:
        """See `Watchdog.energised`. Both must hear of a voltage before it is written."""
        self._watch.energised(on)
        self._link.energised(on)

    def act(self, timeout_s: float) -> SafetyReport | None:
        """See `Watchdog.act`. The watch acts too, unless the guard has read 0 V back."""
        report = self._watch.act(timeout_s)
        if report is not None and report.is_safe:
            self._link.energised(on=False)
        return report


@contextmanager
def watched(rig: Rig, session: Path) -> Iterator[Watchdog]:
    """Start the watchdog of a run. Raise NotReadyError if it cannot; nothing is energised then.

    If this program is killed, the guard leaves its report beside the session.
    """
    forget_guard_report(session)  # of an earlier one of this name
    with _guard_of(rig, session) as guard, _with_the_watch(rig, guard) as watch:
        if rig.interlock is None:
            yield watch
            return
        try:
            rig.interlock.open()
        except DeviceError as fault:
            raise NotReadyError(str(fault)) from fault
        except (Exception, SystemExit) as fault:
            why = f"the interlock's line cannot be opened: {type(fault).__name__}: {fault}"
            raise NotReadyError(why) from fault
        try:
            yield InterlockWatchdog(watch, rig.interlock)
        finally:
            with suppress(Exception, SystemExit):  # without edges it drops, which is the safe side
                rig.interlock.close()


@contextmanager
def _with_the_watch(rig: Rig, guard: Watchdog) -> Iterator[Watchdog]:
    """Add the watch at the boards, where rig.toml names one."""
    watch = None if rig.config.is_simulated else rig.config.watch
    if watch is None:
        yield guard
        return
    try:
        token = read_token(watch.token)
        link = WatchLink(*watch.host_and_port, token, output_place(rig.config))
    except DeviceError as fault:
        raise NotReadyError(str(fault)) from fault
    try:
        yield FarWatchdog(guard, link)
    finally:
        link.close()


@contextmanager
def _guard_of(rig: Rig, session: Path) -> Iterator[Watchdog]:
    """Start the guard's process where the rig is a real one."""
    if rig.config.is_simulated:
        yield NoWatchdog()
        return
    try:
        guard = Guard.start(_settings(rig, session))
    except DeviceError as fault:
        raise NotReadyError(str(fault)) from fault
    except (Exception, SystemExit) as fault:
        raise NotReadyError(
            f"the output guard cannot be told of the boards of [{rig.config.boards_kind}]: "
            f"{type(fault).__name__}: {fault}"
        ) from fault
    try:
        yield guard
    finally:
        guard.disarm()  # acts first when 0 V was not confirmed
        forget_guard_report(session)  # we live, so the session itself says how it ended


def _settings(rig: Rig, session: Path) -> GuardSettings:
    return GuardSettings(
        boards=rig.config.boards_kind,
        place=output_place(rig.config),
        time_under_voltage_s=rig.config.limits.time_under_voltage_s + _GRACE_S,
        at_zero_limit_s=AT_ZERO_LIMIT_S,
        report_path=str(guard_report_path(session).absolute()),
        address=str(getattr(rig.config.boards, "address", "")),
    )
