"""A fake rig for tests of protocols and drivers: small devices in memory, on a clock that jumps.

Whoever writes a protocol can run it here without hardware and without waiting:

    rig = FakeRig()
    rig.scheduler().run(short_schedule(0.01))
    assert rig.output.last_V == 0.0

Each device has a `CallFaults` in `rig.faults`, which makes chosen calls fail. The force is 1 mN
per V behind 1 V/N and a slow ramp, the current 1 mA per V, the read-back what was written.
"""

from __future__ import annotations

from typing import TypeVar

from drivers.safe_shutdown import SafetyReport, make_safe
from labrig.testing.fake_devices import (
    CHANNELS,
    LIMITS,
    CallFaults,
    FakeCamera,
    FakeClock,
    FakeOperator,
    FakeOutput,
    FakeSignals,
    FakeStage,
)
from protocols import Devices, Place, Schedule, Scheduler, StopRequest, make_schedule
from protocols.execution.events import Event
from protocols.kinds.pulse_train import PulseTrain

E = TypeVar("E", bound=Event)

SHORT_TRAIN = PulseTrain(zero_readings=2, pulses_discarded=1, readings_per_voltage=1, pulse_s=0.6)


class FakeRig:
    """All devices together, and the events that came out."""

    def __init__(self, *, camera: bool = True) -> None:
        names = ("output", "signals", "camera", "stage", "operator")
        self.faults = {name: CallFaults() for name in names}
        self.clock = FakeClock()
        self.output = FakeOutput(self.clock, self.faults["output"])
        self.signals = FakeSignals(self.clock, self.output, self.faults["signals"])
        self.camera = FakeCamera(self.clock, self.faults["camera"])
        self.stage = FakeStage(self.clock, self.faults["stage"])
        self.operator = FakeOperator(self.clock, self.output, self.faults["operator"])
        self.devices = Devices(
            output=self.output,
            signals=self.signals,
            camera=self.camera if camera else None,
            stage=self.stage,
            operator=self.operator,
            channels=CHANNELS,
        )
        self.stop = StopRequest()
        self.events: list[Event] = []
        self.beats_s: list[float] = []
        self.guarded: list[bool] = []

    def make_safe(self) -> SafetyReport:
        """Write 0 V and read it back."""
        return make_safe(self.output, self.signals, self.clock, "drive", 0.05)

    def beat(self) -> None:
        """Note the time of a heartbeat."""
        self.beats_s.append(self.clock.time_s)

    def scheduler(self, **more: object) -> Scheduler:
        """Return a scheduler on this rig; keywords replace its settings."""
        settings: dict[str, object] = {
            "emit": self.events.append,
            "limits": LIMITS,
            "make_safe": self.make_safe,
            "beat": self.beat,
            "on_energised": self.guarded.append,
            "wall": lambda: "2026-01-01T00:00:00.000+00:00",
        }
        settings.update(more)
        return Scheduler(self.devices, self.clock, stop=self.stop, **settings)  # type: ignore[arg-type]

    def of_kind(self, kind: type[E]) -> list[E]:
        """Return the events of a kind."""
        return [event for event in self.events if isinstance(event, kind)]


def short_schedule(*positions_m: float) -> Schedule:
    """Return a schedule with one short pulse train at each position."""
    return make_schedule(SHORT_TRAIN, [Place("long", positions_m or (0.0,))])
