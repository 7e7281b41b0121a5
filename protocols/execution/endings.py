"""What an exception means for a session: why it ends, in a word and in a sentence."""

from __future__ import annotations

from collections.abc import Callable

from drivers.interfaces import DeviceError, OverloadError, behind, in_words, is_mistake
from protocols.execution.event_bus import SubscriberError
from protocols.execution.operator import DeclinedError, NoAnswerError
from protocols.execution.runs.control_loop import ControlFaultError
from protocols.execution.runs.run_context import Stopped
from protocols.execution.states import FinishReason

# Says in whose code an error was raised, where it is not labrig's: a distribution, file and line.
Whose = Callable[[BaseException], str | None]


def reason_of(error: BaseException, whose: Whose) -> tuple[FinishReason, str]:
    """Return what an exception means for the session, and the sentence for the operator.

    What a part of another distribution raised is told with the place that `whose` finds, unless it
    is a DeviceError: its sentence is meant for the operator.
    """
    finish, text = _reason_of(error)
    cause = behind(error)
    of_a_device = finish is FinishReason.DEVICE_FAULT and not isinstance(cause, DeviceError)
    asked = of_a_device or finish is FinishReason.INTERNAL_ERROR or is_mistake(cause)
    place = _place(cause, whose) if asked else None
    if place is None:
        return finish, text
    if finish is FinishReason.INTERNAL_ERROR:
        text = f"a part of another distribution failed: {in_words(error)}"
    return finish, f"{text}, in {place}"


def _place(cause: BaseException, whose: Whose) -> str | None:
    try:
        return whose(cause)
    except Exception:  # noqa: BLE001 - the session ends with what is known
        return None


def _reason_of(error: BaseException) -> tuple[FinishReason, str]:
    text = str(error) or type(error).__name__
    if isinstance(error, Stopped):
        return error.finish, text
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
