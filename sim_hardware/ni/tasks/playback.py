"""Running generations put their samples on the outputs, each at its time."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

from drivers.interfaces import Clock
from sim_hardware.ni.errors import Code
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.signals.generation import Generation
from sim_hardware.ni.tasks.task import Task

_LOOK_S = 0.1  # a thread notices so soon that its generation has ended
_LEAST_S = 1e-3  # changes that are nearer to each other are passed on together


class Playback:
    """All generations that are under way. Called with the engine's lock held."""

    def __init__(
        self,
        clock: Clock,
        lock: threading.Lock,
        write: Callable[[Task, int, float, float], None],
        faults: Faults,
    ) -> None:
        """`write` puts volts on a channel of a task at a time."""
        self._clock = clock
        self._lock = lock
        self._write = write
        self._faults = faults
        self._playing: list[tuple[Task, Generation]] = []

    def begin(self, task: Task) -> None:
        """Follow a generation whose clock has begun, in a thread of its own."""
        generation = task.generation
        if generation is None or any(each is generation for _, each in self._playing):
            return
        self._playing.append((task, generation))
        self._clock.start_thread(lambda: self._play(task, generation), f"output of {task.name}")

    def advance(self) -> None:
        """Pass on all changes up to now."""
        if not self._playing:
            return
        now_s = self._clock.now()
        found = [
            (when_s, task, channel, volts)
            for task, generation in self._playing
            for when_s, channel, volts in generation.changes(now_s)
        ]
        for when_s, task, channel, volts in sorted(found, key=lambda change: change[0]):
            self._write(task, channel, volts, when_s)
        if self._faults.underflow:
            for _, generation in self._playing:
                generation.failed = int(Code.FIFO_UNDERFLOW)
        self._playing = [(t, g) for t, g in self._playing if t.generation is g]

    def _play(self, task: Task, generation: Generation) -> None:
        while True:
            with self._lock:
                self.advance()
                if task.generation is not generation:
                    return
                now_s = self._clock.now()
                due_s = generation.next_change_s(now_s)
            if math.isinf(due_s):
                due_s = now_s + _LOOK_S
            self._clock.sleep_until(min(max(due_s, now_s + _LEAST_S), now_s + _LOOK_S))
