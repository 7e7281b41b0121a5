"""What every run of a session is executed with, and how its end is asked for."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from drivers.interfaces import Clock
from protocols.execution.devices import Devices
from protocols.execution.event_bus import SubscriberError
from protocols.execution.events import Event, Warned
from protocols.execution.output import GuardedOutput
from protocols.execution.rules import Rules
from protocols.execution.states import FinishReason, RunState
from protocols.execution.stop import StopRequest
from protocols.planning.loop_timing import LoopTiming


class Stopped(Exception):  # noqa: N818 - not an error: a request is followed
    """The session is to end; the text is the reason that was given."""

    def __init__(self, why: str, finish: FinishReason = FinishReason.STOP_REQUESTED) -> None:
        super().__init__(why)
        self.finish = finish

    @classmethod
    def by(cls, request: StopRequest) -> Stopped:
        """As it was asked for."""
        return cls(request.why, request.finish)


@dataclass(frozen=True, kw_only=True)
class RunContext:
    """What all runs of a session are executed with."""

    devices: Devices
    output: GuardedOutput
    clock: Clock
    emit: Callable[[Event], None]
    stop: StopRequest
    beat: Callable[[], None]  # called at least every 50 ms while energised
    enter: Callable[[RunState], None]
    rules: Rules
    timing: LoopTiming
    keep_all_frames: bool
    limit_V: float  # at the sheet
    longest_timed_s: float = 0.0  # a run that its board may put out by itself

    def guarded(self, what: str, act: Callable[[], object]) -> BaseException | None:
        """Do something while cleaning up: a failure is reported and does not stop the rest.

        Unless it is one of a required subscriber, such as a full disk: it fails with each event,
        and the session ends with its sentence.
        """
        try:
            act()
        except SubscriberError as error:
            return error
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it is, the clean-up continues
            with suppress(Exception):
                self.emit(Warned(self.clock.now(), f"{what}: {error or type(error).__name__}"))
            return error
        return None

    def emit_if_possible(self, event: Event) -> None:
        """Emit an event while cleaning up after a failure, which may be the recording's own."""
        with suppress(Exception):
            self.emit(event)
