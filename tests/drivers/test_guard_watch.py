"""When the guard acts, on a clock and a pipe made of plain data."""

import queue
import threading
from dataclasses import replace

import pytest

from drivers.guard.settings import (
    ACT,
    AT_ZERO,
    AT_ZERO_LIMIT_S,
    BEAT,
    DISARM,
    ENERGISED,
    NEW_RUN,
    RUN_OVER,
    GuardSettings,
)
from drivers.guard.suspect import AT_A_DEVICE, AT_THE_BOARDS, IN_THE_PROGRAM, sign_of, what_hangs
from drivers.guard.watch import Ending, ParentWatchdog
from drivers.interfaces import DeviceError, RealClock
from drivers.safe_shutdown import in_time

SETTINGS = GuardSettings(
    boards="ni",
    place={
        "address": "127.0.0.1:1",
        "output_channel": "PCI6703/ao0",
        "drive_channel": "PCI6034E/ai2",
    },
    time_under_voltage_s=30.0,
)
DEATH = b""


class Pipe:
    """Words that arrive at given times; waiting makes time pass. It is the clock too."""

    def __init__(self, *words: tuple[float, bytes], stalls: tuple[float, float] | None = None):
        self.coming = sorted(words, key=lambda word: word[0])
        self.time_s = 0.0
        self.stalls = stalls  # the guard itself gets no processor between these times
        self.confirmed = 0

    def now(self) -> float:
        return self.time_s

    def get(self, timeout: float) -> bytes:
        until = self.time_s + timeout
        if self.coming and self.coming[0][0] <= until:
            when, word = self.coming.pop(0)
            self.time_s = max(self.time_s, when)
            return word
        self.time_s = until
        if self.stalls and self.stalls[0] <= self.time_s < self.stalls[1]:
            self.time_s = self.stalls[1]
        raise queue.Empty

    def confirm(self) -> None:
        self.confirmed += 1


def beats(from_s: float, to_s: float, every_s: float = 0.05) -> list[tuple[float, bytes]]:
    count = round((to_s - from_s) / every_s)
    return [(from_s + i * every_s, BEAT) for i in range(count)]


def watch(pipe: Pipe, lives=lambda: True, settings=SETTINGS) -> tuple[Ending, float]:
    ending = ParentWatchdog(settings, pipe, pipe, pipe.confirm, lives).until_end()
    return ending, pipe.time_s


def test_a_program_that_finishes_is_let_go():
    words = [(0.1, ENERGISED), *beats(0.15, 5.0), (5.0, AT_ZERO), (60.0, DISARM)]
    assert watch(Pipe(*words)) == (Ending.DISARMED, 60.0)


def test_a_pipe_that_closes_is_noticed_at_once():
    assert watch(Pipe((0.1, ENERGISED), *beats(0.15, 1.0), (1.01, DEATH))) == (Ending.GONE, 1.01)


def test_death_counts_at_zero_volts_too():
    assert watch(Pipe((2.0, DEATH))) == (Ending.GONE, 2.0)


def test_a_program_that_dies_while_another_holds_its_pipe_is_noticed():
    pipe = Pipe((0.1, ENERGISED), *beats(0.15, 100.0))
    ending, when = watch(pipe, lives=lambda: pipe.time_s < 3.0)
    assert ending is Ending.GONE
    assert when == pytest.approx(3.0, abs=0.05)


def test_silence_while_energised_is_a_hang_after_400_ms():
    ending, when = watch(Pipe((0.1, ENERGISED), *beats(0.15, 2.0)))
    assert ending is Ending.HUNG
    assert when == pytest.approx(1.95 + 0.4, abs=0.03)


def test_silence_at_zero_volts_is_no_hang():
    words = [(0.1, ENERGISED), *beats(0.15, 1.0), (1.0, AT_ZERO), (500.0, DISARM)]
    assert watch(Pipe(*words)) == (Ending.DISARMED, 500.0)


AT_ZERO_TOO = replace(SETTINGS, at_zero_limit_s=AT_ZERO_LIMIT_S)


def test_a_run_that_is_silent_at_zero_volts_hangs():
    words = [(0.1, NEW_RUN), *beats(1.0, 30.0, every_s=1.0)]
    ending, when = watch(Pipe(*words), settings=AT_ZERO_TOO)
    assert ending is Ending.HUNG
    assert when == pytest.approx(29.0 + AT_ZERO_LIMIT_S, abs=0.1)


def test_between_two_runs_a_person_may_take_any_time():
    words = [(0.1, NEW_RUN), *beats(1.0, 5.0, every_s=1.0), (5.0, RUN_OVER), (900.0, DISARM)]
    assert watch(Pipe(*words), settings=AT_ZERO_TOO) == (Ending.DISARMED, 900.0)


def test_before_the_first_run_a_person_may_take_any_time():
    assert watch(Pipe((900.0, DISARM)), settings=AT_ZERO_TOO) == (Ending.DISARMED, 900.0)


def test_a_beat_just_in_time_is_enough():
    words = [(0.1, ENERGISED), *beats(0.4, 20.0, every_s=0.38), (20.1, DISARM)]
    assert watch(Pipe(*words))[0] is Ending.DISARMED


def test_a_program_that_beats_for_ever_is_stopped_after_its_time_under_voltage():
    ending, when = watch(Pipe((1.0, ENERGISED), *beats(1.05, 100.0)))
    assert ending is Ending.TOO_LONG
    assert when == pytest.approx(31.6, abs=0.1)


def pulses(count: int, every_s: float, from_s: float = 0.0) -> list[tuple[float, bytes]]:
    """As many pulses, half of the time at 0 V."""
    words = []
    for pulse in range(count):
        began, half = from_s + pulse * every_s, every_s / 2
        words += [(began, ENERGISED), *beats(began + 0.05, began + half), (began + half, AT_ZERO)]
    return words


def test_the_time_under_voltage_of_a_run_is_that_of_all_its_pulses_together():
    ending, when = watch(Pipe(*pulses(20, 4.0)))
    assert ending is Ending.TOO_LONG
    assert when == pytest.approx(15 * 4.0 + 0.6, abs=0.2)


def test_each_run_begins_the_time_under_voltage_anew():
    words = []
    for run in range(5):
        words += [(100.0 * run, NEW_RUN), *pulses(14, 4.0, 100.0 * run + 1.0)]
    words.append((600.0, DISARM))
    assert watch(Pipe(*words)) == (Ending.DISARMED, 600.0)


def test_saying_energised_again_does_not_begin_the_time_anew():
    words = [(float(second), ENERGISED) for second in range(100)]
    ending, when = watch(Pipe(*words, *beats(0.05, 100.0)))
    assert ending is Ending.TOO_LONG
    assert when == pytest.approx(30.6, abs=0.1)


def test_a_guard_that_got_no_processor_does_not_blame_the_program():
    """Its beats of that time are still in the pipe when the guard wakes."""
    words = [(0.1, ENERGISED), *beats(0.15, 5.0), (5.0, AT_ZERO), (6.0, DISARM)]
    gap = [word for word in words if not 2.0 < word[0] < 3.0]
    assert watch(Pipe(*gap, stalls=(2.0, 3.0)))[0] is Ending.DISARMED


@pytest.mark.parametrize(
    ("stalls", "least_s", "most_s"),
    [((2.1, 2.5), 2.5, 2.75), ((2.1, 4.0), 4.0, 4.25), ((2.1, 2.2), 2.35, 2.45)],
)
def test_a_watch_at_another_computer_adds_none_of_its_own_stalls_to_a_silence(
    stalls: tuple[float, float], least_s: float, most_s: float
) -> None:
    """The program stands still from 2.0 s on; the watch gets no processor for a while."""
    pipe = Pipe((0.1, ENERGISED), *beats(0.15, 2.0), stalls=stalls)
    watchdog = ParentWatchdog(SETTINGS, pipe, pipe, pipe.confirm, lambda: True, grace_s=0.2)
    assert watchdog.until_end() is Ending.HUNG
    assert least_s <= pipe.time_s <= most_s


def test_a_watch_that_got_no_processor_hears_what_has_come_meanwhile() -> None:
    words = [(0.1, ENERGISED), *beats(0.15, 5.0), (5.0, AT_ZERO), (6.0, DISARM)]
    gap = [word for word in words if not 2.0 < word[0] < 3.1]
    pipe = Pipe(*gap, stalls=(2.0, 3.0))
    watchdog = ParentWatchdog(SETTINGS, pipe, pipe, pipe.confirm, lambda: True, grace_s=0.2)
    assert watchdog.until_end() is Ending.DISARMED


def test_a_hang_that_begins_during_such_a_gap_is_still_found():
    words = [(0.1, ENERGISED), *beats(0.15, 2.0)]
    ending, when = watch(Pipe(*words, stalls=(2.0, 3.0)))
    assert ending is Ending.HUNG
    assert when < 3.0 + 0.5


def test_every_word_is_confirmed():
    pipe = Pipe((0.1, ENERGISED), (0.12, BEAT), (0.13, BEAT + BEAT + AT_ZERO), (0.2, DISARM))
    watch(pipe)
    assert pipe.confirmed == 3


def test_settings_survive_the_pipe():
    assert GuardSettings.from_json(SETTINGS.to_json()) == SETTINGS
    assert "\n" not in SETTINGS.to_json()


@pytest.mark.parametrize("text", ["", "{}", "[]", "3", '{"place": {}}', '{"place": 1}',
                                  SETTINGS.to_json().replace("heartbeat", "hartbeat")])  # fmt: skip
def test_settings_that_do_not_fit_are_refused(text):
    with pytest.raises(DeviceError, match="settings cannot be read"):
        GuardSettings.from_json(text)


def test_a_program_can_ask_the_guard_to_act():
    assert watch(Pipe((0.1, ENERGISED), (0.2, ACT))) == (Ending.ASKED, 0.2)


def signs(sign: bytes, from_s: float, to_s: float) -> list[tuple[float, bytes]]:
    return [(when, sign) for when, _ in beats(from_s, to_s, every_s=0.1)]


def test_a_life_sign_is_no_heartbeat():
    pipe = Pipe((0.1, ENERGISED), *beats(0.15, 2.0), *signs(AT_THE_BOARDS, 2.1, 9.0))
    ending, when = watch(pipe)
    assert ending is Ending.HUNG
    assert when == pytest.approx(1.95 + 0.4, abs=0.03)


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        (signs(AT_THE_BOARDS, 2.1, 9.0), AT_THE_BOARDS),
        (signs(AT_A_DEVICE, 2.1, 9.0), AT_A_DEVICE),
        ([], None),
        ([(2.0, AT_THE_BOARDS)], None),  # then the whole program stood still
    ],
)
def test_the_newest_life_sign_tells_where_the_loop_hangs(given, kept):
    pipe = Pipe((0.1, ENERGISED), *beats(0.15, 2.0), *given)
    watchdog = ParentWatchdog(SETTINGS, pipe, pipe, pipe.confirm, lambda: True)
    assert watchdog.until_end() is Ending.HUNG
    assert watchdog.sign == kept


@pytest.mark.parametrize(
    ("sign", "address", "answer", "words"),
    [
        (None, "host:1", True, "the program hangs"),
        (IN_THE_PROGRAM, "host:1", False, "the program hangs"),
        (AT_THE_BOARDS, "host:1", False, "the device server at host:1 does not answer"),
        (AT_THE_BOARDS, "host:1", True, "the program's connection to the device server at host:1"),
        (AT_THE_BOARDS, "local", False, "the boards' driver does not answer"),
        (AT_THE_BOARDS, "local", True, "the boards' driver does not return to the program"),
        (AT_A_DEVICE, "host:1", True, "a device other than the boards"),
        (AT_A_DEVICE, "host:1", False, "the device server at host:1 and another device do not"),
    ],
)
def test_the_words_say_what_has_hung(sign, address, answer, words):
    assert what_hangs(sign, "ni", address, boards_answer=answer).startswith(words)


def test_boards_of_another_family_are_named_by_their_kind():
    said = what_hangs(AT_THE_BOARDS, "acme", "192.0.2.7", boards_answer=False)
    assert said == "acme at 192.0.2.7 does not answer"


def test_a_safe_shutdown_that_tries_again_waits_for_the_boards():
    began, over = threading.Event(), threading.Event()

    def refused() -> None:
        began.set()
        over.wait(10)

    clock = RealClock()
    loop = threading.Thread(target=in_time, args=(clock, "writing 0 V", refused, 10.0))
    loop.start()
    try:
        assert began.wait(10)
        assert sign_of(loop.ident) == AT_THE_BOARDS
    finally:
        over.set()
        loop.join()
