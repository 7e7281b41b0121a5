"""A controller sets the voltage, period by period, so that the force follows its reference.

Each period: samples are read, the force is their mean over the last period, the controller's next
voltage is kept within the limits and written. Whatever is not as it should be is raised, and the
run loop writes 0 V: a period that begins late, samples that are old, lost or at the end of the
input's range, a voltage that is no number, or that stays at its limit for too long.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from drivers.interfaces import DeviceError, DeviceTimeoutError, FloatArray, SampleClock
from protocols.execution.channels import ChannelRows
from protocols.execution.events import Controlled, ControlPeriod
from protocols.execution.rules import bad_samples
from protocols.execution.runs.run_context import RunContext, Stopped
from protocols.execution.samples import SampleBuffer
from protocols.execution.stop import StopLevel
from protocols.planning.schedule import PlannedRun

FRESH_PERIODS = 3  # the newest sample may be this old
LATE_PERIODS = 1  # a period may begin this late
_ROUNDING_S = 1e-9


class ControlFaultError(Exception):
    """The controller cannot go on; the text is one sentence for the operator."""


@dataclass(frozen=True, kw_only=True)
class FeedbackLaw:
    """u = C x + D [r, y], x+ = A x + B [r, y] + w (written - u), once each period; r, y in N."""

    A: FloatArray  # (n, n)
    B: FloatArray  # (n, 2): reference, measured force
    C: FloatArray  # (n,)
    D: FloatArray  # (2,)
    anti_windup: FloatArray  # (n,) w
    rate_hz: float
    limit_V: float  # of the voltage, either sign
    saturated_s: float  # the voltage may be at its limit for so long

    @property
    def period_s(self) -> float:
        """Return the time from one write to the next."""
        return 1.0 / self.rate_hz

    def within(self, limit_V: float) -> FeedbackLaw:
        """Return the same law with no larger limit of the voltage than this one."""
        return replace(self, limit_V=min(self.limit_V, limit_V))


class ControlLoop:
    """The controlled part of one run."""

    def __init__(
        self,
        context: RunContext,
        run: PlannedRun,
        law: FeedbackLaw,
        sample_clock: SampleClock,
        zero_s: float,
    ) -> None:
        """`zero_s`: clock time of the run's time 0, from which the reference counts."""
        self._context = context
        self._run = run
        self._law = law
        self._clock = sample_clock
        self._zero_s = zero_s
        self._rows: ChannelRows = context.devices.rows()
        self._state = np.zeros(len(law.A))
        self._window = max(1, round(sample_clock.rate_hz * law.period_s))  # samples of a period
        self._zero_N = 0.0  # the force at 0 V
        self._saturated_from_s: float | None = None
        self._periods: list[ControlPeriod] = []
        self._next_service_s = zero_s
        self._reference_s = [step.time_s for step in run.reference]

    def until(
        self,
        end_s: float,
        samples: SampleBuffer,
        *,
        take_samples: Callable[[], None],
        service: Callable[[], None],
    ) -> bool:
        """Control until a moment. False, at once, when a stop after the pulse is asked for.

        `take_samples` adds to `samples` what has arrived. `service` does that and whatever else a
        run has to do now and then. Raises Stopped, ControlFaultError, DeviceError.
        """
        context, law = self._context, self._law
        take_samples()
        self._require_fresh(samples)
        self._zero_N = self._mean_force(samples, self._at_rest(samples))
        period = 1
        while (due_s := self._zero_s + period * law.period_s) < end_s - 0.5 * law.period_s:
            self._wait(due_s, service)
            if context.stop.level is StopLevel.NOW:
                raise Stopped.by(context.stop)
            if context.stop.level is not StopLevel.NONE:
                return False
            self._require_in_time(due_s)
            take_samples()
            self._require_fresh(samples)
            self._act(due_s, samples)
            if context.clock.now() >= self._next_service_s:
                self._service(service)
            period += 1
        self._wait(end_s, service)
        return True

    def not_emitted(self) -> Iterator[Controlled]:
        """Yield the periods that no event has reported yet."""
        if self._periods:
            periods, self._periods = tuple(self._periods), []
            yield Controlled(
                self._context.clock.now(), run=self._run.index, zero_N=self._zero_N, periods=periods
            )

    def _wait(self, due_s: float, service: Callable[[], None]) -> None:
        """Beat and service while there is time for it."""
        context = self._context
        context.beat()
        while context.clock.now() + context.timing.service_s < due_s:
            context.clock.sleep_until(context.clock.now() + context.timing.service_s)
            context.beat()
            self._service(service)
            if context.stop.level is not StopLevel.NONE:
                return
        context.clock.sleep_until(due_s)

    def _service(self, service: Callable[[], None]) -> None:
        self._next_service_s = self._context.clock.now() + self._context.timing.service_s
        service()
        for event in self.not_emitted():
            self._context.emit(event)

    def _require_in_time(self, due_s: float) -> None:
        late_s, limit_s = self._context.clock.now() - due_s, LATE_PERIODS * self._law.period_s
        if late_s > limit_s:
            raise ControlFaultError(
                f"the control loop came {1e3 * late_s:.1f} ms late (limit {1e3 * limit_s:g} ms); "
                "use a less busy computer or a controller with a lower rate"
            )

    def _require_fresh(self, samples: SampleBuffer) -> None:
        newest_s = self._clock.time_of(samples.end - 1)
        age_s, limit_s = self._context.clock.now() - newest_s, FRESH_PERIODS * self._law.period_s
        if not age_s <= limit_s:
            raise DeviceTimeoutError(
                f"the newest sample of the force is {1e3 * age_s:.0f} ms old, and the controller "
                f"needs one within {FRESH_PERIODS} periods ({1e3 * limit_s:g} ms); check the "
                "connection to the input"
            )

    def _at_rest(self, samples: SampleBuffer) -> int:
        """Return how many of the last samples were taken at 0 V before the run."""
        lead_in = int(self._context.timing.lead_in_s * self._clock.rate_hz)
        return min(max(lead_in, self._window), samples.end)

    def _mean_force(self, samples: SampleBuffer, count: int) -> float:
        """Return the mean of the last samples, N. Raises DeviceError where it means nothing."""
        row = self._rows.force
        channel = self._rows.channels[row]
        raw = samples.between(samples.end - count, samples.end - 1)[row]
        for why in bad_samples(raw[None], [channel]):
            raise DeviceError(f"the controller cannot use the force: {why}")
        force_N = float(np.mean(channel.convert(raw)))
        if not isfinite(force_N):
            raise DeviceError("the controller cannot use the force: it is not a number")
        return force_N

    def _act(self, due_s: float, samples: SampleBuffer) -> None:
        """Compute the next voltage and write it, within the limits."""
        law = self._law
        force_N = self._mean_force(samples, self._window) - self._zero_N
        given = np.array([self._reference_at(due_s), force_N])
        with np.errstate(all="ignore"):  # what overflows is found below, or by the next period
            wanted_V = float(law.C @ self._state + law.D @ given)
            written_V = min(max(wanted_V, -law.limit_V), law.limit_V)
            off_V = written_V - wanted_V
            self._state = law.A @ self._state + law.B @ given + law.anti_windup * off_V
        if not isfinite(wanted_V):
            raise ControlFaultError(
                "the controller asks for a voltage that is not a number; check its file"
            )
        self._note_saturation(written_V != wanted_V)
        write = self._context.output.write(written_V)
        self._periods.append(
            ControlPeriod(
                due_s=due_s,
                sample_index=samples.end - 1.0,
                reference_N=float(given[0]),
                force_N=force_N,
                wanted_V=wanted_V,
                write=write,
            )
        )
        self._context.output.report("a controller sets the voltage")

    def _reference_at(self, due_s: float) -> float:
        """Return the force that is wanted at a clock time, N above that at 0 V."""
        step = bisect_right(self._reference_s, due_s - self._zero_s + _ROUNDING_S) - 1
        return self._run.reference[step].force_N

    def _note_saturation(self, saturated: bool) -> None:
        now_s = self._context.clock.now()
        if not saturated:
            self._saturated_from_s = None
            return
        self._saturated_from_s = now_s if self._saturated_from_s is None else self._saturated_from_s
        if now_s - self._saturated_from_s > self._law.saturated_s:
            raise ControlFaultError(
                f"the voltage was at its limit of ±{self._law.limit_V:g} V for "
                f"{self._law.saturated_s:g} s: the reference is out of reach, or the sheet is not "
                "what the controller was made for"
            )
