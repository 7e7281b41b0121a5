"""What a session is doing, and why it ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from protocols.execution.events import Outcome, OutputState


class RunState(StrEnum):
    """What the scheduler is doing; see `Scheduler` for the diagram."""

    IDLE = "idle"
    PREPARING = "preparing"  # between runs, at 0 V: operator and stage
    LEADING_IN = "leading_in"  # acquisition runs, the first step is not due yet
    RUNNING = "running"
    TAILING = "tailing"  # at 0 V again, the last readings come in
    PAUSED = "paused"  # between runs, 0 V read back, until somebody lets it continue
    STOPPING = "stopping"  # something ended the session; making safe
    FINISHED = "finished"
    UNKNOWN = "unknown"  # finished, and the output may not be at 0 V


class FinishReason(StrEnum):
    """Why a session ended."""

    COMPLETED = "completed"
    STOP_REQUESTED = "stop_requested"
    DECLINED = "declined"  # by the operator, when asked for something
    NO_ANSWER = "no_answer"  # the operator could not be asked
    OVERLOAD = "overload"
    DEVICE_FAULT = "device_fault"
    CONTROL_FAULT = "control_fault"  # the feedback loop was late, saturated, or without a number
    RECORDING_FAULT = "recording_fault"  # a subscriber that the session depends on failed
    RECORDING_ENDED = "recording_ended"  # a replay, of a session that a fault has ended
    INTERNAL_ERROR = "internal_error"  # a mistake in the program
    UNKNOWN = "unknown"  # not finished yet

    @property
    def outcome(self) -> Outcome:
        """As it is recorded."""
        return _OUTCOMES.get(self, Outcome.FAILED)


_OUTCOMES = {
    FinishReason.COMPLETED: Outcome.COMPLETED,
    FinishReason.STOP_REQUESTED: Outcome.ABORTED,
    FinishReason.DECLINED: Outcome.ABORTED,
    FinishReason.UNKNOWN: Outcome.RUNNING,
}


@dataclass(frozen=True, kw_only=True)
class Status:
    """A snapshot for other threads; a new one replaces it as a whole."""

    state: RunState = RunState.IDLE
    run: int | None = None  # the present or last run
    output: OutputState = OutputState.UNKNOWN
    finish: FinishReason = FinishReason.UNKNOWN
    text: str = ""  # the reason in words
    energised_once: bool = False  # whether a voltage was ever asked for
    error: BaseException | None = None  # what ended the session, for a log
