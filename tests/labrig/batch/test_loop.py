"""Every task ends once, whatever happens to the workers."""

from __future__ import annotations

import os
import random
import signal
import threading
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import suppress

import pytest

from labrig.batch import LocalPool, WorkerLostError, worked
from labrig.batch.pool import ONE_THREAD
from labrig.errors import LabrigError
from tests.labrig.batch import costless

pytestmark = pytest.mark.slow  # processes are started


def all_of(todo, work, pool, **more):
    return [
        one for ended in worked(todo, work, pool, lambda: pool.workers, **more) for one in ended
    ]


@pytest.fixture(scope="module")
def pool():
    with LocalPool(2) as pool:
        yield pool


def test_tasks_are_done_in_other_processes_of_one_thread_each(pool):
    assert {one.result for one in all_of(range(5), costless.process_id, pool)} <= set(pool.pids)
    (one,) = all_of([ONE_THREAD], costless.environment, pool)
    assert one.result == ["1"] * len(ONE_THREAD)


def test_an_executor_of_others_will_do():
    with ThreadPoolExecutor(2) as threads:
        found = [one for e in worked(range(50), costless.square, threads, lambda: 2) for one in e]
    assert sorted(one.result for one in found) == [k * k for k in range(50)]


def test_a_task_that_raises_is_tried_three_times_and_the_others_are_done(pool):
    assert [one.attempts for one in all_of([1], costless.raised, pool)] == [3]
    (one,) = all_of([1], costless.raised, pool)
    assert isinstance(one.error, RuntimeError)
    assert [one.result for one in all_of([7], costless.square, pool)] == [49]


def test_a_task_that_kills_its_worker_is_lost_and_takes_no_other_along(pool):
    ended = all_of([1, 2], costless.killed, pool)
    assert all(isinstance(one.error, WorkerLostError) for one in ended)
    assert [one.attempts for one in ended] == [3, 3]
    assert "SIGKILL" in str(ended[0].error)
    assert sorted(one.result for one in all_of(range(20), costless.square, pool)) == [
        k * k for k in range(20)
    ]


def test_what_a_killed_worker_was_doing_is_done_by_another(pool, tmp_path):
    todo = [(str(tmp_path), k) for k in range(4)]
    ended = all_of(todo, costless.killed_once, pool)
    assert sorted(one.result for one in ended) == [0, 1, 2, 3]
    assert all(one.attempts == 2 for one in ended)


@pytest.mark.thorough
def test_workers_killed_at_any_moment_lose_nothing_and_double_nothing():
    dice = random.Random(3)
    over = threading.Event()
    kills = 0

    def kill(pool):
        nonlocal kills
        while not over.wait(dice.uniform(0.0, 0.25)):
            for pid in pool.pids[:1]:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                    kills += 1

    with LocalPool(2) as pool:
        killer = threading.Thread(target=kill, args=(pool,))
        killer.start()
        try:
            ended = all_of(range(300), costless.slowly, pool, attempts=1000)
        finally:
            over.set()
            killer.join(60)
    assert kills > 3
    assert sorted(one.task for one in ended) == list(range(300))
    assert all(one.result == one.task**2 for one in ended)


def test_a_worker_killed_while_it_is_idle_is_replaced(pool):
    for pid in pool.pids:
        os.kill(pid, signal.SIGKILL)
    assert [one.result for one in all_of([3], costless.square, pool)] == [9]


def test_results_larger_than_a_pipe_come_back_whole(pool):
    (one,) = all_of([10**6], bytes, pool)
    assert one.result == bytes(10**6)


class Gone(Executor):
    """Takes one task, and is gone."""

    def __init__(self):
        self.taken = 0

    def submit(self, fn, /, *args, **kwargs):
        self.taken += 1
        if self.taken > 1:
            raise RuntimeError("connection lost")
        with ThreadPoolExecutor(1) as threads:
            return threads.submit(fn, *args, **kwargs)


def test_an_executor_that_takes_no_more_tasks_ends_the_batch_with_a_sentence():
    ends = worked(range(3), costless.square, Gone(), lambda: 1)
    assert next(ends)[0].result == 0
    with pytest.raises(LabrigError, match="the same command goes on"):
        next(ends)


def test_no_more_is_handed_over_than_there_are_places():
    asked = []

    def tasks():
        for k in range(100):
            asked.append(k)
            yield k

    with ThreadPoolExecutor(2) as threads:
        ends = worked(tasks(), costless.square, threads, lambda: 3)
        next(ends)
        assert len(asked) <= 6
        ends.close()
