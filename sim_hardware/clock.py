"""Time that passes only when everybody waits: a simulated session takes as long as its arithmetic.

The thread that makes a `VirtualClock` and the threads it starts take turns: exactly one of them
runs. Who waits hands its turn to whoever wakes earliest (of two at the same time, to the one that
asked first) and time jumps there. So a session is the same to the last bit every time.
"""

from __future__ import annotations

import heapq
import itertools
import math
import threading
from collections.abc import Callable

INTERRUPTED_S = 5.0  # of the real clock
STUCK_S = 120.0  # of the real clock: a compilation on a busy computer may take a minute


class _Waiter:
    """A thread that takes turns."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.turn = threading.Lock()  # released by whoever hands us the turn
        self.turn.acquire()
        self.waits = 0  # counts turns; an alarm set for an earlier wait is void
        self.ended = False
        self.joiners: list[tuple[_Waiter, int]] = []
        self.joins: _Waiter | None = None  # whose end it waits for, without a time-out
        self.left_behind = False  # it has kept its turn for too long, and gets no other


class VirtualThread:
    """A thread that lives in virtual time."""

    def __init__(self, clock: VirtualClock, seat: _Waiter) -> None:
        self._clock = clock
        self._seat = seat

    def join(self, timeout: float | None = None) -> bool:
        """Wait, in virtual time, for the thread's end; return whether it has ended."""
        return self._clock._join(self._seat, timeout)


class VirtualClock:
    """A `drivers.interfaces.Clock` of virtual time.

    Threads that it does not know (a gRPC server's, a library's) may ask the time; whoever of them
    waits gets a RuntimeError. A thread of the clock that waits by anything else (a queue, an event)
    holds up all others, and for ever if it waits for one of them. Only a `join` with a time-out
    ends: a thread that keeps its turn for `STUCK_S` meanwhile is left behind.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._now = start_s
        self._alarms: list[tuple[float, int, _Waiter, int]] = []  # a heap: when, order, who, wait
        self._order = itertools.count()
        self._guard = threading.Lock()  # of the heap, for a wait that Ctrl-C cuts short
        self._here = threading.local()
        self._here.seat = self._holder = _Waiter("first")  # of the turn
        self._turns = 0

    def now(self) -> float:
        """See `Clock.now`."""
        return self._now

    def sleep_until(self, when: float) -> None:
        """See `Clock.sleep_until`."""
        me = self._me()
        if not math.isfinite(when):
            raise ValueError(f"a virtual clock cannot wait until {when} s")
        if when <= self._now:
            return
        self._set_alarm(when, me, me.waits)
        self._wait(me)

    def jump(self, seconds: float) -> None:
        """Let time pass without waking a thread: the computer was suspended."""
        with self._guard:
            self._now += seconds

    def start_thread(self, target: Callable[[], None], name: str) -> VirtualThread:
        """See `Clock.start_thread`. The thread gets its first turn when the caller waits."""
        self._me()
        seat = _Waiter(name)
        self._set_alarm(self._now, seat, seat.waits)
        thread = threading.Thread(target=self._run, args=(seat, target), name=name, daemon=True)
        thread.start()
        return VirtualThread(self, seat)

    def _run(self, seat: _Waiter, target: Callable[[], None]) -> None:
        self._here.seat = seat
        seat.turn.acquire()
        try:
            target()
        except BaseException as fault:  # noqa: BLE001 - reported as any thread's, in its own turn
            thread = threading.current_thread()
            args = (type(fault), fault, fault.__traceback__, thread)
            threading.excepthook(threading.ExceptHookArgs(args))
        finally:
            seat.ended = True
            for joiner, wait in seat.joiners:
                self._set_alarm(self._now, joiner, wait)
            successor = self._next(seat)
            if successor is not None:
                successor.turn.release()

    def _join(self, other: _Waiter, timeout: float | None) -> bool:
        me = self._me()
        if not other.ended and (timeout is None or timeout > 0):
            other.joiners.append((me, me.waits))
            if timeout is None:
                me.joins = other
                _refuse_circle(me)
            else:
                self._set_alarm(self._now + timeout, me, me.waits)
            try:
                self._wait(me, -1.0 if timeout is None else STUCK_S)
            finally:
                me.joins = None
        return other.ended

    def _me(self) -> _Waiter:
        seat: _Waiter | None = getattr(self._here, "seat", None)
        if seat is None:
            raise RuntimeError(
                f"the thread {threading.current_thread().name} waits by a virtual clock that has "
                "not started it; start it with the clock's start_thread, or use the real clock"
            )
        if seat.left_behind:
            raise RuntimeError(f"the thread {seat.name} was left behind: it kept its turn too long")
        return seat

    def _set_alarm(self, when: float, seat: _Waiter, wait: int) -> None:
        with self._guard:
            heapq.heappush(self._alarms, (when, next(self._order), seat, wait))

    def _next(self, me: _Waiter) -> _Waiter | None:
        """Move time on to the next alarm and return whose it is; `me` has the turn."""
        with self._guard:
            while self._alarms and not me.left_behind:
                when, _, seat, wait = heapq.heappop(self._alarms)
                if wait == seat.waits:
                    seat.waits += 1
                    self._now = max(self._now, when)
                    self._turns, self._holder = self._turns + 1, seat
                    return seat
        return None

    def _wait(self, me: _Waiter, stuck_s: float = -1.0) -> None:
        """Hand the turn on; return when it is ours again.

        It is taken from a thread that keeps it for `stuck_s` of the real clock (-1: never).
        """
        successor = self._next(me)
        if successor is me:
            return
        if successor is None:
            raise RuntimeError(
                f"the thread {me.name} waits, and no other thread is left to wake it"
            )
        wait = me.waits
        successor.turn.release()
        try:
            turns = self._turns
            while not me.turn.acquire(timeout=stuck_s):
                if self._turns == turns and self._took_turn(me, wait):
                    break
                turns = self._turns
        except BaseException:  # Ctrl-C: it is not our turn, so ask for it, and then raise
            self._set_alarm(self._now, me, wait)
            me.turn.acquire(timeout=INTERRUPTED_S)  # who has the turn may keep it for ever
            raise

    def _took_turn(self, me: _Waiter, wait: int) -> bool:
        """Leave the thread behind that has the turn, unless it has handed it on to us just now."""
        with self._guard:
            if me.waits != wait:
                return False
            self._holder.left_behind = True
            self._turns, self._holder = self._turns + 1, me
            me.waits += 1
            return True


def _refuse_circle(me: _Waiter) -> None:
    """Raise when the thread that `me` waits for waits, perhaps through others, for `me`."""
    other = me.joins
    while other is not None:
        if other is me:
            me.joins = None
            raise RuntimeError(f"the thread {me.name} waits for a thread that waits for it")
        other = other.joins
