"""What is asked of the operator: every question and answer as an event, and runs offered again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from drivers.interfaces import Clock, DeviceError, Operator, Prompt, in_words
from protocols.execution.events import (
    Event,
    OperatorAnswered,
    OperatorAsked,
    OperatorNotAsked,
    ReadingTaken,
)
from protocols.planning.preparation import Action
from protocols.planning.schedule import PlannedReading, PlannedRun, ReadingKind, Schedule
from protocols.reasons import in_short

REPEAT = "repeat"  # kind of the prompt; True: go on without them, False: measure the run again
EXPIRES_S = 120.0  # a session that nobody attends does not wait for ever
_DISMOUNTING = frozenset({"mount", "remount", "turn_over", "dead_weight"})


class DeclinedError(Exception):
    """The operator has answered no."""


class NoAnswerError(Exception):
    """The operator could not be asked."""


class RecordedOperator:
    """An `Operator` that tells of what is asked. A manual stage is given the same one.

    `is_present`: whether there is an operator who can answer. One without the attribute is.
    `expired` of an operator: whether nobody answered the last question in its time.
    """

    def __init__(self, operator: Operator, clock: Clock, emit: Callable[[Event], None]) -> None:
        self._operator = operator
        self.is_present: bool = getattr(operator, "is_present", True)
        self._clock = clock
        self._emit = emit

    def ask(self, prompt: Prompt) -> bool:
        """See `Operator.ask`; NoAnswerError when nobody can be asked."""
        if not self.is_present:
            self._emit(OperatorNotAsked(self._clock.now(), prompt))
            return self._answer(prompt)
        self._emit(OperatorAsked(self._clock.now(), prompt))
        done = self._answer(prompt)
        expired = getattr(self._operator, "expired", False)
        self._emit(OperatorAnswered(self._clock.now(), prompt, done, expired))
        return done

    def _answer(self, prompt: Prompt) -> bool:
        try:
            return bool(self._operator.ask(prompt))
        except DeviceError:
            raise
        except Exception as error:
            raise NoAnswerError(in_words(error)) from error


class LostReadings:
    """Which readings of which run do not count. Discarded ones would not have counted anyhow."""

    def __init__(self) -> None:
        self._why: dict[int, dict[int, str]] = {}

    def note(self, event: ReadingTaken) -> None:
        """Note a reading that is not valid."""
        if not event.valid and event.planned.kind is not ReadingKind.DISCARDED:
            self._why.setdefault(event.run, {})[event.planned.index] = event.why

    def of(self, run: PlannedRun) -> dict[int, str]:
        """Return why each of a run's readings does not count, by index."""
        return self._why.get(run.index, {})


def counting(run: PlannedRun) -> list[PlannedReading]:
    """Return the readings that would count."""
    return [each for each in run.readings if each.kind is not ReadingKind.DISCARDED]


def all_done(runs: Iterable[PlannedRun], lost: LostReadings) -> str:
    """Return the end of a session whose runs are done, with what does not count of them."""
    runs = list(runs)
    why = [text for run in runs for text in lost.of(run).values()]
    if not why:
        return "all runs are done"
    readings = sum(len(counting(run)) for run in runs)
    return f"all runs are done; {len(why)} of {readings} readings do not count: {in_short(why)}"


def dismounts(actions: list[Action]) -> bool:
    """Whether the sheet as it is mounted is gone after these."""
    return any(isinstance(each, Prompt) and each.kind in _DISMOUNTING for each in actions)


def offers(schedule: Schedule, mounted: list[PlannedRun], lost: LostReadings) -> Iterator[
    tuple[Prompt, PlannedRun]
]:  # fmt: skip
    """Yield for each run with lost readings what to ask, and the run that repeats it."""
    spare = {run.repeats: run for run in schedule.repeats}
    for run in mounted:
        why = lost.of(run)
        if why and run.index in spare:
            yield _offer(run, why), spare[run.index]


def _offer(run: PlannedRun, why: dict[int, str]) -> Prompt:
    where = "free" if run.position_m is None else f"{run.position_m * 1e3:g} mm"
    text = (
        f"{len(why)} of {len(counting(run))} readings of run {run.index + 1} ({run.configuration}, "
        f"{where}) do not count: {in_short(why.values())}. The sheet is still mounted: go on "
        f"without them, or measure this run again now? (After {EXPIRES_S:g} s it goes on.)"
    )
    return Prompt(
        kind=REPEAT,
        text=text,
        configuration=run.configuration,
        position_m=run.position_m,
        expires_s=EXPIRES_S,
    )
