"""What the scheduler tells its subscribers: the session file, the progress bar, the panel.

Events are frozen and complete: a subscriber needs nothing else to follow a session. Clock times are
those of the injected `drivers.interfaces.Clock`; `wall` is the UTC time of day as ISO 8601.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from drivers.interfaces import Frame, Prompt, SampleClock, SignalBlock, VoltageWrite
from protocols.execution.channels import Values
from protocols.planning.schedule import PlannedReading, PlannedRun


class Outcome(StrEnum):
    """How a session ended, or that it has not."""

    RUNNING = "running"
    COMPLETED = "completed"
    ABORTED = "aborted"  # by the operator or a signal
    FAILED = "failed"  # by a fault
    CRASHED = "crashed"  # found out afterwards: nobody wrote an outcome


class OutputState(StrEnum):
    """What is known of the voltage at the sheet."""

    SAFE = "safe"  # 0 V written and read back
    ARMED = "armed"  # the output is open, at 0 V
    ENERGISED = "energised"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Event:
    """Something happened at `time_s` (clock)."""

    time_s: float


@dataclass(frozen=True)
class SessionStarted(Event):
    """The first event."""

    wall: str


@dataclass(frozen=True)
class Resumed(Event):
    """These runs were taken in an earlier session, of which this one is the continuation."""

    identifier: str  # of that session
    runs: tuple[int, ...]


@dataclass(frozen=True)
class OperatorAsked(Event):
    """The operator is being asked for something; the session waits."""

    prompt: Prompt


@dataclass(frozen=True)
class OperatorAnswered(Event):
    """And has answered; `done` is False when the session is to stop."""

    prompt: Prompt
    done: bool
    expired: bool = False  # nobody has answered in the prompt's time, which counts as `done`


@dataclass(frozen=True)
class OperatorNotAsked(Event):
    """Something was to be done by hand, and nobody is there who was asked, or has answered."""

    prompt: Prompt


@dataclass(frozen=True, kw_only=True)
class RunStarted(Event):
    """Acquisition runs; `time_s` is the run's time 0, at which the first step is due."""

    run: PlannedRun
    sample_clock: SampleClock
    channels: tuple[str, ...]
    frame_shape: tuple[int, int] | None  # None: no camera
    stage_position_m: float | None  # as the stage reports it
    since_wetting_s: float | None  # None: nobody said when


@dataclass(frozen=True, kw_only=True)
class VoltageSet(Event):
    """A step was written; `time_s` is the moment just after the device confirmed it."""

    run: int
    step: int
    due_s: float  # clock time at which it was due
    write: VoltageWrite


@dataclass(frozen=True, kw_only=True)
class ControlPeriod:
    """One period of a controller: what it was given, what it asked for, what was written."""

    due_s: float  # clock time at which it was due
    sample_index: float  # of the newest sample that it knew
    reference_N: float  # both forces are counted from that at 0 V before the run
    force_N: float
    wanted_V: float  # before the limits
    write: VoltageWrite


@dataclass(frozen=True, kw_only=True)
class Controlled(Event):
    """Periods of a controller, in their order."""

    run: int
    zero_N: float  # the force at 0 V before the run, as the load cell reads it
    periods: tuple[ControlPeriod, ...]


@dataclass(frozen=True)
class SignalsArrived(Event):
    """A block of raw samples."""

    run: int
    block: SignalBlock


@dataclass(frozen=True, kw_only=True)
class ReadingTaken(Event):
    """One reading, as seen while running; the analysis makes it anew from the raw samples."""

    run: int
    planned: PlannedReading
    sample_index: float  # of the sampling point, from the write of its step
    sample_time_s: float  # clock time of the sampling point
    values: Values  # of every channel at the sampling point: force_N, drive_V (as read back), ...
    frame: Frame | None  # the frame nearest to the sampling point
    frame_offset_s: float | None  # its time minus that of the sampling point
    valid: bool
    why: str  # the reason when not valid


@dataclass(frozen=True)
class FramesArrived(Event):
    """Frames on top of those of the readings, when all of them are to be recorded."""

    run: int
    frames: tuple[Frame, ...]


@dataclass(frozen=True, kw_only=True)
class LoadCellLeft(Event):
    """The load cell leaves for another position while a run is acquired, at 0 V."""

    run: int
    position_m: float  # where it goes


@dataclass(frozen=True, kw_only=True)
class LoadCellArrived(Event):
    """It stands there."""

    run: int
    position_m: float
    reported_m: float | None  # by the stage; None: it has no sensor


@dataclass(frozen=True, kw_only=True)
class ReadingMarked(Event):
    """The operator, or a rule, has declared a reading (None: the whole run) invalid."""

    run: int
    reading: int | None
    why: str
    who: str


@dataclass(frozen=True)
class ActionTaken(Event):
    """A person did something at a panel, in words that follow their name."""

    who: str
    what: str


@dataclass(frozen=True)
class OutputChanged(Event):
    """The state of the output changed."""

    state: OutputState
    why: str


@dataclass(frozen=True)
class Warned(Event):
    """Something the operator should know; the session goes on."""

    text: str


@dataclass(frozen=True, kw_only=True)
class RunStopped(Event):
    """The run's acquisition has ended."""

    run: int
    completed: bool
    lost_samples: int
    frames_grabbed: int  # whole
    frames_dropped: int  # of these: lost because the computer was busy
    frames_incomplete: int = 0  # came with a part missing
    frames_missed: int = 0  # never came

    @property
    def losses(self) -> str:
        """What was lost, in words; empty: nothing."""
        whys = {
            "came incomplete": self.frames_incomplete,
            "never came": self.frames_missed,
            "came faster than they were taken": self.frames_dropped,
        }
        frames = sum(whys.values())
        if not self.lost_samples and not frames:
            return ""
        reasons = ", ".join(f"{count} {why}" for why, count in whys.items() if count)
        words = f"{self.lost_samples} samples and {frames} frames were lost"
        return f"{words} ({reasons})" if reasons else words


@dataclass(frozen=True, kw_only=True)
class SessionStopped(Event):
    """The last event, always sent, after the output was made safe or could not be."""

    outcome: Outcome
    reason: str
    output: OutputState
    wall: str
