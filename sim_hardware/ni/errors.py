"""Faults as NI-DAQmx reports them: a status code and a text."""

from __future__ import annotations

from enum import IntEnum


class Code(IntEnum):
    """The status codes that the simulated boards answer with."""

    RESERVED = -50103
    INVALID_VALUE = -200077
    RATE_AND_CHANNELS = -200081
    INVALID_TASK = -200088
    DUPLICATE_TASK = -200089
    SAMPLE_COUNT = -200096
    NO_SUCH_CHANNEL = -200170
    NOT_SUPPORTED = -200197
    BUFFER_ON_DEMAND = -200217
    NO_SUCH_DEVICE = -200220
    ARRAY_TOO_SMALL = -200229
    INVALID_TERMINAL = -200254
    REFERENCE_NOT_DONE = -200281
    NO_REFERENCE_TRIGGER = -200282
    REFERENCE_WHEN_CONTINUOUS = -200358
    REFERENCE_ON_DEMAND = -200907
    FIFO_UNDERFLOW = -200621
    GENERATION_UNDERFLOW = -200290
    NEGATIVE_READ_SAMPLE = -200277
    NEGATIVE_WRITE_SAMPLE = -200287
    NO_LONGER_WRITEABLE = -200289
    NO_ROOM_YET = -200292
    OUTPUT_BUFFER_EMPTY = -200462
    OVERWRITTEN = -200279
    NEVER_AVAILABLE = -200278
    NOT_YET_AVAILABLE = -200284
    WRONG_CHANNEL_TYPE = -200430
    WRITE_NOT_OUTPUT = -200459
    READ_NOT_INPUT = -200460
    NO_CHANNELS = -200478
    TASK_RUNNING = -200479
    CHANNEL_TWICE = -200489
    RANGE_SYNTAX = -200498
    ONE_CHANNEL_OF_SEVERAL = -200523
    WRITE_CHANNEL_COUNT = -200524
    PORT_PER_LINE = -200528
    PROPERTY_WHILE_RUNNING = -200557
    MIXED_CHANNELS = -200559
    NOT_DONE = -200560
    VALUE_OUT_OF_LIMITS = -200561
    LINE_COUNT = -200463
    NOT_STARTED = -200846
    EVENT_NOT_BUFFERED = -200848
    EVENT_INTERVAL_ZERO = -200880
    DONE_EVENT_TWICE = -200950
    EVENT_WHILE_RUNNING = -200960
    EVENT_UNREGISTER_RUNNING = -200986
    EVENT_TWICE = -200966
    EVENT_TRANSFERRED_UNSUPPORTED = -200980
    EVENT_ACQUIRED_UNSUPPORTED = -200981


TEXTS: dict[int, str] = {
    Code.RESERVED: "The specified resource is reserved. The operation could not be completed as "
    "specified.",
    Code.INVALID_VALUE: "Requested value is not a supported value for this property.",
    Code.RATE_AND_CHANNELS: "The sample rate, the number of channels and the convert rate do not "
    "fit together: the conversions of one sample take longer than a sample period.",
    Code.INVALID_TASK: "Task specified is invalid or does not exist.",
    Code.DUPLICATE_TASK: "Task name specified conflicts with an existing task name.",
    Code.SAMPLE_COUNT: "The requested number of samples to read is invalid: it must be -1 (all "
    "available) or not negative.",
    Code.NO_SUCH_CHANNEL: "Physical channel specified does not exist on this device.",
    Code.NOT_SUPPORTED: "Specified property is not supported by the device or is not applicable to "
    "the task.",
    Code.BUFFER_ON_DEMAND: "A buffer, or more than one sample per channel, cannot be used with "
    "on-demand timing.",
    Code.NO_SUCH_DEVICE: "Device identifier is invalid.",
    Code.ARRAY_TOO_SMALL: "Buffer is too small to fit read data.",
    Code.INVALID_TERMINAL: "Terminal for the device is invalid.",
    Code.REFERENCE_NOT_DONE: "Attempted to read samples relative to the reference trigger before "
    "the acquisition was complete.",
    Code.NO_REFERENCE_TRIGGER: "Attempted to read samples relative to the reference trigger or the "
    "first pretrigger sample, but no reference trigger is configured.",
    Code.REFERENCE_WHEN_CONTINUOUS: "Reference trigger cannot be used when the sample mode is "
    "continuous.",
    Code.REFERENCE_ON_DEMAND: "Reference trigger is not supported for the timing type of the task.",
    Code.FIFO_UNDERFLOW: "Onboard device memory underflow: the generation was stopped because the "
    "samples did not reach the device fast enough.",
    Code.GENERATION_UNDERFLOW: "The generation has stopped to prevent the regeneration of old "
    "samples: no new samples were written in time.",
    Code.NEGATIVE_READ_SAMPLE: "Attempted to read a sample preceding the first one acquired.",
    Code.NEGATIVE_WRITE_SAMPLE: "Attempted to write to a position before the first sample.",
    Code.NO_LONGER_WRITEABLE: "Requested samples can no longer be written: they have been "
    "generated already.",
    Code.NO_ROOM_YET: "Some or all of the samples to write could not be written to the buffer yet.",
    Code.OUTPUT_BUFFER_EMPTY: "Generation cannot be started, because the output buffer is empty.",
    Code.OVERWRITTEN: "The application is not able to keep up with the hardware acquisition: the "
    "samples asked for are no longer in the buffer.",
    Code.NEVER_AVAILABLE: "The samples asked for will never be acquired: the task has stopped.",
    Code.NOT_YET_AVAILABLE: "Some or all of the samples requested have not yet been acquired.",
    Code.WRONG_CHANNEL_TYPE: "I/O type of the physical channel does not fit the channel to be "
    "made.",
    Code.WRITE_NOT_OUTPUT: "Write failed, because there are no output channels in this task.",
    Code.READ_NOT_INPUT: "Read failed, because there are no input channels in this task.",
    Code.NO_CHANNELS: "Specified operation cannot be performed when there are no channels in the "
    "task.",
    Code.TASK_RUNNING: "Specified operation cannot be performed while the task is running.",
    Code.CHANNEL_TWICE: "Specified channel cannot be added to the task, because a channel with the "
    "same name is already in the task.",
    Code.RANGE_SYNTAX: "Syntax for a range of objects in the input string is invalid.",
    Code.ONE_CHANNEL_OF_SEVERAL: "A read of one value cannot be performed on a task with several "
    "channels.",
    Code.WRITE_CHANNEL_COUNT: "Write cannot be performed, because the amount of data does not fit "
    "the number of channels in the task.",
    Code.PROPERTY_WHILE_RUNNING: "Specified property cannot be set while the task is running.",
    Code.PORT_PER_LINE: "Entire ports cannot be made channels of one line each: name the lines.",
    Code.MIXED_CHANNELS: "Specified channel cannot be added: a task holds channels of one type.",
    Code.NOT_DONE: "Wait until done did not indicate that the task was done within the timeout.",
    Code.VALUE_OUT_OF_LIMITS: "Attempted writing analog data that is too large or too small.",
    Code.LINE_COUNT: "The number of lines does not fit the digital channel.",
    Code.NOT_STARTED: "The task is not running and auto start is off: start the task first.",
    Code.EVENT_NOT_BUFFERED: "Every N samples event is not supported for tasks without a buffer.",
    Code.EVENT_INTERVAL_ZERO: "Every N samples event needs an interval of at least one sample.",
    Code.DONE_EVENT_TWICE: "Done event is already registered within the task.",
    Code.EVENT_WHILE_RUNNING: "An event cannot be registered while the task is running.",
    Code.EVENT_UNREGISTER_RUNNING: "An event cannot be unregistered while the task is running.",
    Code.EVENT_TRANSFERRED_UNSUPPORTED: "Every N samples transferred from buffer event is not "
    "supported by the device or the task.",
    Code.EVENT_ACQUIRED_UNSUPPORTED: "Every N samples acquired into buffer event is not supported "
    "by the device or the task.",
    Code.EVENT_TWICE: "Every N samples acquired into buffer event is already registered.",
}


class StatusError(Exception):
    """A call that the driver refuses."""

    def __init__(
        self,
        code: int,
        detail: str = "",
        task: str = "",
        samples_read: int | None = None,
        samples_written: int | None = None,
    ) -> None:
        self.code = int(code)
        self.samples_read = samples_read
        self.samples_written = samples_written
        text = TEXTS.get(code, "Refused.")
        if detail:
            text += f"\n\n{detail}"
        if task:
            text += f"\n\nTask Name: {task}"
        super().__init__(f"{text}\n\nStatus Code: {int(code)}")


class NotSimulatedError(Exception):
    """Something that the real server can do and this one does not: answered UNIMPLEMENTED."""


class SessionError(Exception):
    """A session that must not exist does (`exists`), or one that must, does not."""

    def __init__(self, text: str, *, exists: bool) -> None:
        super().__init__(text)
        self.exists = exists


def error_string(code: int) -> str:
    """Return the text of a status code; empty for a code that is not known."""
    return TEXTS.get(code, "")
