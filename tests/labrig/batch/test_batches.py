"""A batch that is broken off goes on; what is at fault is said; what has changed is done again."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest

from labrig.batch.plan import ROWS
from labrig.batch.rows import PieceOutcome, rows_in
from labrig.batch.run import one_by_one, run_batch
from labrig.batch.workers import local_workers
from tests.labrig.batch.a_batch import do_batch, planned
from tests.labrig.batch.costless import Costless
from tests.processes import ended

pytestmark = pytest.mark.slow  # processes are started
ROOT = Path(__file__).parents[3]


@pytest.fixture
def folder(tmp_path):
    """Two files that pass for sessions: the task does not look into them."""
    for name in ("a.h5", "b.h5"):
        (tmp_path / name).write_bytes(name.encode())
    return tmp_path


def rows_of(plan):
    return list(rows_in(plan.folder / ROWS))


def names_once(plan):
    """The names of all rows; each must be there once."""
    counts = Counter(row.name for row in rows_of(plan))
    assert set(counts.values()) <= {1}
    return set(counts)


def test_a_batch_finds_what_one_by_one_finds(folder):
    task = Costless(count=30)
    alone = {row.name: row.digest for row in one_by_one(planned(folder, task).todo)}
    plan = do_batch(folder, task)
    assert {row.name: row.digest for row in rows_of(plan)} == alone
    assert len(names_once(plan)) == 60


@pytest.mark.thorough
def test_workers_killed_at_any_moment_leave_every_row_there_once(folder):
    dice, kills = random.Random(1), []
    plan = planned(folder, Costless(count=60, wait_s=0.005))

    def perhaps_kill(*_):
        """Both workers are in the middle of something, or just starting."""
        if dice.random() < 0.08:
            pid = dice.choice(workers.executor.pids)
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
                kills.append(pid)

    with local_workers(2) as workers:
        run_batch(plan, workers.executor, workers.places, perhaps_kill)
    assert len(kills) > 4
    assert all(row.outcome is PieceOutcome.DONE for row in rows_of(plan))
    assert names_once(plan) == set(plan.names)


def test_a_killed_program_goes_on_where_it_was_and_does_nothing_twice(folder):
    path = folder / "out" / "costless" / ROWS
    kills = 0
    for wanted in (5, 60):
        command = [sys.executable, "-m", "tests.labrig.batch.a_batch", str(folder), "60"]
        process = subprocess.Popen(command, cwd=ROOT)
        while process.poll() is None and sum(1 for _ in rows_in(path)) < wanted:
            threading.Event().wait(0.02)
        if process.poll() is None:
            process.kill()
            kills += 1
        ended(process)
    assert kills == 2
    plan = do_batch(folder, Costless(count=60, wait_s=0.01))
    assert 0 < len(plan.todo) < 120
    assert names_once(plan) == set(plan.names)
    assert not planned(folder, Costless(count=60, wait_s=0.01)).todo


@pytest.mark.thorough
def test_a_fault_of_the_file_is_said_at_once_and_other_errors_are_tried_three_times(folder):
    plan = do_batch(folder, Costless(count=6, faulty=5, broken=3))
    by_name = {row.name: row for row in rows_of(plan)}
    fault, broken = by_name["a.h5 piece 5"], by_name["a.h5 piece 3"]
    assert (fault.outcome, fault.attempts) == (PieceOutcome.FAULT, 1)
    assert fault.sentence.endswith("piece 5 is at fault.")
    assert (broken.outcome, broken.attempts) == (PieceOutcome.FAULT, 3)
    assert broken.sentence == "failed with RuntimeError: piece 3."
    assert by_name["a.h5 piece 1"].outcome is PieceOutcome.DONE


def test_a_piece_that_kills_its_worker_is_lost_and_all_others_are_done(folder):
    plan = do_batch(folder, Costless(count=5, deadly=2))
    outcomes = {row.name: (row.outcome, row.attempts) for row in rows_of(plan)}
    for name in ("a.h5 piece 2", "b.h5 piece 2"):
        assert outcomes.pop(name) == (PieceOutcome.LOST, 3)
    assert len(outcomes) == 8
    assert set(outcomes.values()) == {(PieceOutcome.DONE, 1)}
    again = planned(folder, Costless(count=5, deadly=2))  # what has killed them may be over
    assert [piece.item.name for piece in again.todo] == ["a.h5 piece 2", "b.h5 piece 2"]


@pytest.mark.thorough
def test_errors_are_left_alone_until_they_are_asked_for(folder):
    task = Costless(count=4, faulty=2)
    do_batch(folder, task)
    again = planned(folder, task)
    assert (len(again.todo), again.done, again.faulty) == (0, 4, 4)
    assert len(planned(folder, task, retry_errors=True).todo) == 4


@pytest.mark.thorough
def test_content_and_options_decide_what_is_done_and_not_the_time_of_a_file(folder):
    task = Costless(count=2)
    do_batch(folder, task)
    os.utime(folder / "a.h5", (1, 1))
    assert not planned(folder, task).todo
    (folder / "a.h5").write_bytes(b"other")
    assert [piece.item.name for piece in planned(folder, task).todo] == [
        "a.h5 piece 0",
        "a.h5 piece 1",
    ]
    assert len(planned(folder, Costless(count=2, broken=9)).todo) == 4


@pytest.mark.thorough
def test_results_and_files_may_be_moved_together(folder, tmp_path_factory):
    do_batch(folder, Costless(count=2))
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "moved"
    folder.rename(elsewhere)
    assert not planned(elsewhere, Costless(count=2)).todo


@pytest.mark.thorough
def test_a_limit_leaves_the_rest_for_the_next_time(folder):
    task = Costless(count=5)
    plan = do_batch(folder, task, limit=3)
    assert (len(plan.todo), plan.later) == (3, 7)
    plan = do_batch(folder, task)
    assert len(plan.todo) == 7
    assert names_once(plan) == set(plan.names)
