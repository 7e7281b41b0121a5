"""A schedule: every voltage and every reading of a session, as frozen data.

It can be printed, drawn, checked against the limits before any hardware is touched, simulated,
recorded with the session and replayed. Times are in s from the run's beginning.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

from protocols.serialise import OMITTED_AS_DEFAULT

# When a free sheet is within about half a millimetre of its shape at 0 V, and within a tenth of a
# millimetre of that under voltage, where its electrodes charge, too: with the losses of Nafion in
# air, as `model.dynamics` has them.
AT_REST_S = 3.0
SETTLED_S = 6.0


class ReadingKind(StrEnum):
    """What a reading is for."""

    ZERO = "zero"  # taken at 0 V before the first pulse
    DISCARDED = "discarded"  # recorded, but the water has not settled yet
    KEPT = "kept"
    NO_CONTACT = "no_contact"  # nothing touches the load cell: its zero


class Purpose(StrEnum):
    """What a run is for."""

    MEASUREMENT = "measurement"
    NO_TOUCH_ZERO = "no_touch_zero"
    FREE_SHAPE = "free_shape"
    DEAD_WEIGHT = "dead_weight"
    CONTROL = "control"  # a controller sets the voltage, so that the force follows a reference


@dataclass(frozen=True)
class VoltageStep:
    """At `time_s` the sheet voltage becomes `voltage_V` and stays until the next step."""

    time_s: float
    voltage_V: float


@dataclass(frozen=True)
class ForceStep:
    """From `time_s` until the next step the force is to be `force_N` above that at 0 V."""

    time_s: float
    force_N: float


@dataclass(frozen=True, kw_only=True)
class PlannedReading:
    """A reading `delay_s` after its step *as written*, filtered over ± `half_window_s`."""

    index: int  # in time order over the whole run, counting from 0
    step: int  # index into the run's steps
    delay_s: float
    half_window_s: float
    voltage_V: float
    kind: ReadingKind


@dataclass(frozen=True)
class PlannedMove:
    """The load cell leaves for another position at `time_s`; the sheet is at 0 V.

    How long that takes is the stage's. The run goes on as long after the arrival as it was
    planned to go on after `time_s`.
    """

    time_s: float
    position_m: float


@dataclass(frozen=True, kw_only=True)
class PlannedRun:
    """Everything that happens at one setting of sheet and load cell, without a pause."""

    index: int  # in the order of execution
    configuration: str  # a table of sheet.toml: long, short, ...
    # along the arc; None: the load cell is away. In a no-touch zero the load cell stands at its
    # position, but the sheet is out of its rolls.
    position_m: float | None
    purpose: Purpose
    mounting: int  # 0, then 1, 2, ... each time the same position is set anew
    approach: str  # up | down: from which side the position is approached
    moisten: bool  # ask the operator to moisten the sheet first
    load_N: float | None  # dead weight hung on the load cell
    steps: tuple[VoltageStep, ...]  # the first at 0 s; the last one returns to 0 V
    readings: tuple[PlannedReading, ...]
    duration_s: float
    # go here first, so that the position is approached from the right side; None: go straight
    via_m: float | None = None
    # of the rig about the sheet's long axis: 0, or pi where it is turned over; of all runs alike
    tilt_rad: float = 0.0
    repeats: int | None = None  # the run that this one measures again; None: it is none of those
    # what the force is to be between the first step and the last; empty: no controller is at work
    reference: tuple[ForceStep, ...] = field(default=(), metadata=OMITTED_AS_DEFAULT)
    # name of the extra that added the run; empty: it is none of those, or older than this field
    extra: str = field(default="", metadata=OMITTED_AS_DEFAULT)
    keep_all_frames: bool = field(default=False, metadata=OMITTED_AS_DEFAULT)
    move: PlannedMove | None = field(default=None, metadata=OMITTED_AS_DEFAULT)

    @property
    def measures(self) -> bool:
        """Whether it is one of the protocol's own measurements, in contact."""
        return self.purpose is Purpose.MEASUREMENT and not self.extra

    @property
    def in_words(self) -> str:
        """What it is for: the extra that added it, else its purpose."""
        return (self.extra or self.purpose.value).replace("_", " ")

    def time_of(self, reading: PlannedReading) -> float:
        """Planned time of a reading's sampling point, s."""
        return self.steps[reading.step].time_s + reading.delay_s

    def held_s(self, step: int) -> float:
        """Return how long the voltage of a step stays, s; that of the last one for good."""
        if step + 1 >= len(self.steps):
            return math.inf
        return self.steps[step + 1].time_s - self.steps[step].time_s


@dataclass(frozen=True)
class Schedule:
    """The runs of a session in their order, and the name of the protocol that made them."""

    protocol: str
    runs: tuple[PlannedRun, ...]
    frame_rate_hz: float  # wanted of the camera
    # For each measurement a run like it, numbered after all `runs`. One is executed only where
    # readings of its run were lost and the operator wants it measured again.
    repeats: tuple[PlannedRun, ...] = ()

    @property
    def all_runs(self) -> tuple[PlannedRun, ...]:
        """Those that are planned, and then their repeats."""
        return self.runs + self.repeats
