"""Virtual time: deterministic turns, joins that step time, failures that hold nobody up."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from drivers.interfaces import Clock, ThreadHandle
from sim_hardware.clock import VirtualClock


def test_it_is_a_clock() -> None:
    clock: Clock = VirtualClock()
    assert clock.now() == 0.0


def test_an_hour_passes_at_once() -> None:
    clock = VirtualClock(start_s=5.0)
    before = time.perf_counter()
    clock.sleep_until(3605.0)
    assert clock.now() == 3605.0
    assert time.perf_counter() - before < 0.5


def test_a_time_that_has_passed_is_not_waited_for() -> None:
    clock = VirtualClock(start_s=5.0)
    clock.sleep_until(4.0)
    assert clock.now() == 5.0


@pytest.mark.parametrize("when", [float("inf"), float("nan")])
def test_an_endless_wait_is_refused(when: float) -> None:
    with pytest.raises(ValueError, match="cannot wait until"):
        VirtualClock().sleep_until(when)


def test_threads_take_turns_in_the_order_of_time_and_then_of_asking() -> None:
    clock = VirtualClock()
    log: list[tuple[float, str]] = []

    def ticker(name: str, period: float) -> None:
        for k in range(1, 4):
            clock.sleep_until(k * period)
            log.append((clock.now(), name))

    threads = [
        clock.start_thread(lambda: ticker("slow", 2.0), "slow"),
        clock.start_thread(lambda: ticker("fast", 1.0), "fast"),
    ]
    assert log == []  # nobody runs while the caller does
    assert all(thread.join() for thread in threads)
    assert log == [
        (1.0, "fast"),
        (2.0, "slow"),
        (2.0, "fast"),
        (3.0, "fast"),
        (4.0, "slow"),
        (6.0, "slow"),
    ]
    assert clock.now() == 6.0


def test_only_one_thread_runs_at_a_time() -> None:
    clock = VirtualClock()
    running = 0
    most = 0

    def work() -> None:
        nonlocal running, most
        for _ in range(200):
            running += 1
            most = max(most, running)
            for _ in range(50):
                pass
            running -= 1
            clock.sleep_until(clock.now() + 0.001)

    threads = [clock.start_thread(work, f"worker {k}") for k in range(6)]
    for thread in threads:
        thread.join()
    assert most == 1


def test_the_same_program_has_the_same_history() -> None:
    def history() -> list[tuple[float, int]]:
        clock = VirtualClock()
        log: list[tuple[float, int]] = []

        def work(k: int) -> None:
            for step in range(20):
                clock.sleep_until(clock.now() + ((k * 7 + step * 3) % 5) * 0.01 + 0.001)
                log.append((clock.now(), k))

        for thread in [clock.start_thread(lambda k=k: work(k), str(k)) for k in range(5)]:
            thread.join()
        return log

    assert history() == history()


def test_join_gives_up_after_its_timeout_in_virtual_time() -> None:
    clock = VirtualClock()
    thread = clock.start_thread(lambda: clock.sleep_until(10.0), "long")
    assert not thread.join(timeout=4.0)
    assert clock.now() == 4.0
    assert not thread.join(timeout=0)
    assert thread.join()
    assert clock.now() == 10.0
    assert thread.join(timeout=0)


def test_a_timeout_that_was_not_needed_does_not_wake_later() -> None:
    clock = VirtualClock()
    thread = clock.start_thread(lambda: clock.sleep_until(1.0), "short")
    assert thread.join(timeout=5.0)
    clock.sleep_until(20.0)
    assert clock.now() == 20.0


def test_a_thread_may_join_another() -> None:
    clock = VirtualClock()
    log: list[float] = []
    first = clock.start_thread(lambda: clock.sleep_until(3.0), "first")

    def second() -> None:
        first.join()
        log.append(clock.now())

    assert clock.start_thread(second, "second").join()
    assert log == [3.0]


@pytest.mark.parametrize("circle", [1, 2, 3])
def test_threads_that_wait_for_each_other_are_told(circle: int) -> None:
    clock = VirtualClock()
    told: list[str] = []
    handles: list[ThreadHandle] = []

    def wait_for_the_next(k: int) -> None:
        try:
            handles[(k + 1) % circle].join()
        except RuntimeError as fault:
            told.append(str(fault))

    handles.extend(
        clock.start_thread(lambda k=k: wait_for_the_next(k), f"thread {k}") for k in range(circle)
    )
    assert all(handle.join() for handle in handles)  # the one that was told sets the others free
    assert told == [f"the thread thread {circle - 1} waits for a thread that waits for it"]


def test_a_thread_that_fails_is_reported_and_does_not_hang_the_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reported: list[tuple[object, float]] = []
    clock = VirtualClock()
    monkeypatch.setattr(
        threading, "excepthook", lambda args: reported.append((args.exc_value, clock.now()))
    )

    def fail() -> None:
        clock.sleep_until(1.0)
        raise ValueError("on purpose")

    failing = clock.start_thread(fail, "failing")
    assert failing.join()
    assert [(str(fault), when) for fault, when in reported] == [("on purpose", 1.0)]
    clock.sleep_until(2.0)
    assert clock.now() == 2.0


def test_a_thread_the_clock_does_not_know_may_ask_the_time_but_not_wait() -> None:
    clock = VirtualClock()
    seen: list[object] = []

    def stranger() -> None:
        seen.append(clock.now())
        for call in (
            lambda: clock.sleep_until(1.0),
            lambda: clock.start_thread(lambda: None, "child"),
        ):
            try:
                call()
            except RuntimeError as fault:
                seen.append(str(fault))

    thread = threading.Thread(target=stranger, name="stranger")
    thread.start()
    thread.join()
    assert seen[0] == 0.0
    assert len(seen) == 3
    assert all("stranger" in str(text) and "start_thread" in str(text) for text in seen[1:])
    clock.sleep_until(1.0)  # and the clock still works
    assert clock.now() == 1.0


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """Raise KeyboardInterrupt in this thread; by a signal that pytest-timeout does not need."""

    def interrupt(_number: int, _frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGUSR1, interrupt)
    here = threading.get_ident()
    timer = threading.Timer(seconds, lambda: signal.pthread_kill(here, signal.SIGUSR1))
    timer.start()
    try:
        yield
    finally:
        timer.join()
        signal.signal(signal.SIGUSR1, before)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="raises by a signal")
def test_an_interrupt_while_another_runs_waits_for_its_turn() -> None:
    clock = VirtualClock()
    steps: list[float] = []

    def busy() -> None:
        end = time.perf_counter() + 0.3
        while time.perf_counter() < end:
            pass  # does not wait: the main thread's interrupt comes here
        steps.append(clock.now())
        clock.sleep_until(clock.now() + 1.0)
        steps.append(clock.now())

    thread = clock.start_thread(busy, "busy")
    with interrupted_after(0.1), pytest.raises(KeyboardInterrupt):
        clock.sleep_until(10.0)
    assert steps == [0.0]  # it was raised when the busy thread had handed its turn on
    assert clock.now() == 0.0
    thread.join()
    assert steps == [0.0, 1.0]


@pytest.mark.skipif(os.name != "posix", reason="raises by a signal")
def test_a_thread_that_keeps_its_turn_for_ever_does_not_hold_up_ctrl_c(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sim_hardware.clock.INTERRUPTED_S", 0.05)
    clock, never = VirtualClock(), threading.Event()
    clock.start_thread(never.wait, "waits by something else")
    try:
        with interrupted_after(0.05), pytest.raises(KeyboardInterrupt):
            clock.sleep_until(10.0)
    finally:
        never.set()


@pytest.mark.slow
def test_a_change_of_threads_takes_less_than_50_microseconds() -> None:
    clock = VirtualClock()
    changes = 4000

    def tick(offset: float) -> None:
        for k in range(changes // 2):
            clock.sleep_until(k + offset)

    def seconds() -> float:
        threads = [clock.start_thread(lambda o=o: tick(o), "t") for o in (0.25, 0.75)]
        before = time.perf_counter()
        for thread in threads:
            thread.join()
        return time.perf_counter() - before

    assert min(seconds() for _ in range(5)) / changes < 50e-6


def test_a_thread_that_keeps_its_turn_is_left_behind_by_a_join_with_a_time_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Such as a device of somebody else that hangs: the others take their turns as before."""
    monkeypatch.setattr("sim_hardware.clock.STUCK_S", 0.1)
    clock, later = VirtualClock(), list[str]()
    goes_on, ended = threading.Event(), threading.Event()

    def hang() -> None:
        goes_on.wait(20.0)
        try:
            clock.sleep_until(50.0)
        except RuntimeError as error:
            later.append(str(error))
            ended.set()

    def tick() -> None:
        clock.sleep_until(3.0)
        later.append("tick")

    hung = clock.start_thread(hang, "hung")
    ticking = clock.start_thread(tick, "ticking")
    assert not hung.join(8.0)
    assert ticking.join(8.0)
    goes_on.set()
    assert ended.wait(20.0)
    assert later == ["tick", "the thread hung was left behind: it kept its turn too long"]
    clock.sleep_until(60.0)
    assert clock.now() == 60.0


def test_a_thread_that_only_computes_for_long_is_not_left_behind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sim_hardware.clock.STUCK_S", 0.2)
    clock = VirtualClock()

    def compute() -> None:
        for k in range(5):
            threading.Event().wait(0.1)
            clock.sleep_until(k + 1.0)

    assert clock.start_thread(compute, "computing").join(8.0)
    assert clock.now() == 5.0
