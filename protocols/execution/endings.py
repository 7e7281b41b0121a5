"""What an exception means for a session: why it ends, in a word and in a sentence."""

from __future__ import annotations

from drivers.interfaces import DeviceError, OverloadError
from protocols.execution.event_bus import SubscriberError
from protocols.execution.runs.control_loop import ControlFaultError
from protocols.execution.runs.loop import Stopped
from protocols.execution.states import FinishReason


class DeclinedError(Exception):
    """The operator has answered no."""


class NoAnswerError(Exception):
    """The operator could not be asked."""


def reason_of(error: BaseException) -> tuple[FinishReason, str]:
    """Return what an exception means for the session, and the sentence for the operator."""
    text = str(error) or type(error).__name__
    if isinstance(error, Stopped):
        return FinishReason.STOP_REQUESTED, text
    if isinstance(error, KeyboardInterrupt):
        return FinishReason.STOP_REQUESTED, "interrupted from the keyboard"
    if isinstance(error, DeclinedError):
        return FinishReason.DECLINED, text
    if isinstance(error, NoAnswerError):
        return FinishReason.NO_ANSWER, text
    if isinstance(error, OverloadError):
        return FinishReason.OVERLOAD, text
    if isinstance(error, ControlFaultError):
        return FinishReason.CONTROL_FAULT, text
    if isinstance(error, DeviceError):
        return FinishReason.DEVICE_FAULT, text
    if isinstance(error, SubscriberError):
        return FinishReason.RECORDING_FAULT, f"the session could not be recorded: {text}"
    return FinishReason.INTERNAL_ERROR, f"an error in labrig itself: {type(error).__name__}: {text}"
