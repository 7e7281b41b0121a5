"""A task: its channels, its timing, and the states it goes through."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from enum import IntEnum

from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.names import split_list
from sim_hardware.ni.signals.acquisition import Acquisition, ReadPosition, Sampler
from sim_hardware.ni.signals.generation import Generation, OutputBuffer
from sim_hardware.ni.signals.timing import (
    RISING,
    InputPlan,
    OutputPlan,
    SampleMode,
    TaskTiming,
    TimingType,
    plan_input,
    plan_lines,
    plan_output,
)
from sim_hardware.ni.tasks.channels import (
    AnalogInputChannel,
    AnalogOutputChannel,
    Channel,
    ChannelType,
    DigitalChannel,
)
from sim_hardware.ni.tasks.events import TaskEvents

NO_SYNC = 10230  # constants.SyncType.NONE
LEAST_PRETRIGGER, LEAST_POSTTRIGGER = 2, 2  # samples, of the boards' timing engines


class TaskState(IntEnum):
    """The states of a task; each includes those before it."""

    UNVERIFIED = 0
    VERIFIED = 1
    RESERVED = 2
    COMMITTED = 3
    RUNNING = 4


@dataclass
class StartTrigger:
    """What a started task waits for; an empty source: nothing."""

    source: str = ""
    edge: int = RISING
    retriggerable: bool = False  # a finite task waits for the next one when it is done


@dataclass
class ReferenceTrigger:
    """What an acquisition ends with; an empty source: nothing."""

    source: str = ""
    edge: int = RISING
    pretrigger_samples: int = 2


@dataclass(eq=False, kw_only=True)
class Task:
    """A task that a client configures and runs. The engine moves it from state to state."""

    name: str
    owner: str  # a connection where tasks are not shared; else empty
    number: int  # counts the server's tasks; seeds their noise
    channels: list[Channel] = field(default_factory=list)
    timing: TaskTiming = field(default_factory=TaskTiming)
    state: TaskState = TaskState.UNVERIFIED
    auto_start: bool = True  # a read starts the task
    read_all_available: bool = False
    channels_to_read: str = ""
    started_by_read: bool = False
    held: bool = False  # the client has reserved it: a stop then leaves it reserved
    counted: int = 0  # samples of its lines that were read on demand
    starts: int = 0  # seeds the noise of each acquisition
    reads: ReadPosition = field(default_factory=ReadPosition)
    output: OutputBuffer = field(default_factory=OutputBuffer)
    trigger: StartTrigger = field(default_factory=StartTrigger)
    reference: ReferenceTrigger = field(default_factory=ReferenceTrigger)
    sync_type: int = NO_SYNC
    acquisition: Acquisition | None = None  # while it runs by a sample clock
    generation: Generation | None = None  # while it puts out by a sample clock
    on_demand: Sampler | None = None  # while it runs without
    events: TaskEvents = field(default_factory=TaskEvents)

    @property
    def starts_again(self) -> bool:
        """Whether each trigger starts it again."""
        return self.trigger.retriggerable and bool(self.trigger.source)

    @property
    def running(self) -> bool:
        """Started and not stopped; a finite acquisition that is done still runs in this sense."""
        return self.state is TaskState.RUNNING

    @property
    def timed(self) -> Acquisition | Generation | None:
        """What runs by its sample clock."""
        return self.acquisition or self.generation

    @property
    def type(self) -> ChannelType | None:
        """The type that all its channels have."""
        return self.channels[0].type if self.channels else None

    @property
    def inputs(self) -> list[AnalogInputChannel]:
        """Its channels, if they are analog inputs."""
        return [c for c in self.channels if isinstance(c, AnalogInputChannel)]

    @property
    def outputs(self) -> list[AnalogOutputChannel]:
        """Its channels, if they are analog outputs."""
        return [c for c in self.channels if isinstance(c, AnalogOutputChannel)]

    @property
    def digital(self) -> list[DigitalChannel]:
        """Its channels, if they are digital."""
        return [c for c in self.channels if isinstance(c, DigitalChannel)]

    @property
    def device_names(self) -> list[str]:
        """The boards it uses."""
        return list(dict.fromkeys(channel.device.name for channel in self.channels))

    @property
    def engine_names(self) -> list[str]:
        """The boards that time it: a chassis times its modules."""
        return list(dict.fromkeys(channel.device.engine_name for channel in self.channels))

    def add(self, channel: Channel) -> None:
        """One more channel, of the type the others have."""
        self.refuse_while_running(Code.TASK_RUNNING)
        if self.type not in (None, channel.type):
            raise StatusError(Code.MIXED_CHANNELS, task=self.name)
        if any(channel.name.lower() == other.name.lower() for other in self.channels):
            raise StatusError(Code.CHANNEL_TWICE, f"Channel Name: {channel.name}", self.name)
        self.channels.append(channel)
        self.changed()

    def changed(self) -> None:
        """Note that a setting has changed: it will be verified again."""
        if self.state is TaskState.VERIFIED:
            self.state = TaskState.UNVERIFIED

    def refuse_while_running(self, code: Code = Code.PROPERTY_WHILE_RUNNING) -> None:
        """Raise when the task runs."""
        if self.running:
            raise StatusError(code, task=self.name)

    def select(self, names: str) -> Iterator[Channel]:
        """Return the channels in a list of names; all for an empty one."""
        wanted = {name.lower() for name in split_list(names)}
        found = [c for c in self.channels if not wanted or c.name.lower() in wanted]
        if len(found) < max(1, len(wanted)):
            raise StatusError(Code.NO_SUCH_CHANNEL, f"Channel Name: {names}", self.name)
        return iter(found)

    def verify(self) -> InputPlan | OutputPlan | None:
        """Check every setting against the boards; the plan of a clocked task."""
        if not self.channels:
            raise StatusError(Code.NO_CHANNELS, task=self.name)
        clocked = self.outputs and self.timing.kind is not TimingType.ON_DEMAND
        if (self.inputs or clocked) and len(self.device_names) > 1:
            raise NotSimulatedError("a timed task of several boards is not simulated")
        for output in self.outputs:
            output.verified_range()
        for channel in self.inputs:
            channel.verified_range()
        self._verify_triggers()
        if self.timing.kind is TimingType.ON_DEMAND:
            if self.events.every_n is not None:
                raise StatusError(Code.EVENT_NOT_BUFFERED, task=self.name)
            return None
        plan = self._plan()
        if not self.starts_again:
            return plan
        if isinstance(plan, OutputPlan):
            return replace(plan, total=None)
        return replace(plan, total=None, buffer=self.buffer_size())

    def buffer_size(self) -> int:
        """Return the samples per channel that the driver keeps in the computer's memory."""
        return self.timing.buffer_size(starts_again=self.starts_again)

    def _verify_triggers(self) -> None:
        """Check what the triggers ask of the timing."""
        finite = self.timing.mode is SampleMode.FINITE
        if self.starts_again and not finite:
            raise StatusError(Code.NOT_SUPPORTED, "Property: DAQmx_StartTrig_Retriggerable")
        if not self.reference.source:
            return
        if self.outputs or self.digital:
            raise StatusError(Code.NOT_SUPPORTED, "Property: DAQmx_RefTrig_Type", self.name)
        if self.timing.kind is TimingType.ON_DEMAND:
            raise StatusError(Code.REFERENCE_ON_DEMAND, task=self.name)
        if not finite:
            raise StatusError(Code.REFERENCE_WHEN_CONTINUOUS, task=self.name)
        if self.starts_again:
            raise StatusError(Code.NOT_SUPPORTED, "Reference triggers do not start again.")
        least, most = LEAST_PRETRIGGER, self.timing.samples - LEAST_POSTTRIGGER
        if not least <= self.reference.pretrigger_samples <= most:
            raise StatusError(
                Code.INVALID_VALUE,
                "Property: DAQmx_RefTrig_PretrigSamples\n"
                f"Requested Value: {self.reference.pretrigger_samples}\n"
                f"Maximum Value: {most}\nMinimum Value: {least}",
                self.name,
            )

    def _plan(self) -> InputPlan | OutputPlan:
        board = self.channels[0].device.board
        if self.inputs:
            return plan_input(self.timing, self.inputs[0].side, len(self.inputs))
        if self.outputs and all(output.side.clocked for output in self.outputs):
            return plan_output(self.timing, self.outputs[0].side)
        if self.digital and all(channel.buffered for channel in self.digital):
            if self.digital[0].output:
                raise NotSimulatedError("the simulated lines are written on demand only")
            return plan_lines(self.timing)
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_SampTimingType\nRequested: Sample Clock\n{board.product_type} has "
            "static channels: On Demand only",
            self.name,
        )

    def resources(self) -> list[str]:
        """Return the names of what must be reserved for it."""
        found: list[str] = []
        for channel in self.channels:
            device = channel.device.name
            if isinstance(channel, AnalogInputChannel):
                found.append(f"{device}/ai")  # the board has one converter
            elif isinstance(channel, AnalogOutputChannel):
                found.append(f"{device}/{channel.physical}")
                if self.timing.kind is not TimingType.ON_DEMAND:
                    found.append(f"{device}/ao clock")  # the board has one for all outputs
            else:
                found.extend(f"{device}/{line}" for line in channel.lines)
        return found
