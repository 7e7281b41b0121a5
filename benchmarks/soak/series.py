"""A series of runs, each ended by a fault at a random moment."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Callable, Collection
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from io import StringIO
from multiprocessing import get_context
from pathlib import Path

from benchmarks.soak.faults import Fault, Relay, do
from benchmarks.soak.judge import Verdict, judge_data, judge_output
from benchmarks.soak.record import WorldRecord
from benchmarks.soak.rig import Bench, LabrigRun, serving, until
from labrig.cli.main import run as labrig

RUNS_PER_SERVER = 10
EARLY = 0.1  # of all faults come before the first voltage, or just after it
_EARLY_S, _LATE_S = 6.0, 7.0  # moments are drawn up to here
_ENERGISED_S = 60.0  # a busy computer starts slowly
_AFTER_S = 1.5  # the world is watched so long after a fault
_END_S = 60.0  # for a program that lives on after a fault
_TRIES = 6
_GUARD = "labrig's output guard:"  # how its words begin when it has acted
_GUARD_S = 20.0  # for the guard to end


@dataclass(frozen=True)
class Planned:
    """A run of a series: what is done to it, and when."""

    number: int
    fault: Fault
    after_s: float


def soak(
    runs: int,
    seed: int,
    folder: Path,
    tell: Callable[[Verdict], None],
    jobs: int = 1,
    only: Collection[int] = (),
) -> list[Verdict]:
    """Do the runs, `jobs` rigs side by side; `tell` is called for each of a rig's when it is done.

    What is done, and when, is the same for the same seed. With one job `tell` is called at once.
    `only`: leave out all runs but these, to see again what one of them did.
    """
    dice = random.Random(seed)
    faults = list(Fault)
    plan = [Planned(n, faults[n % len(faults)], _moment_s(dice)) for n in range(runs)]
    plan = [planned for planned in plan if not only or planned.number in only]
    each = min(RUNS_PER_SERVER, -(-len(plan) // jobs))  # no rig idle while another is at work
    parts = [plan[at : at + each] for at in range(0, len(plan), max(1, each))]
    if jobs == 1:
        return [verdict for part in parts for verdict in _on_one_rig(part, folder, tell)]
    found: list[Verdict] = []
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        for done in as_completed(pool.submit(_on_one_rig, part, folder) for part in parts):
            for verdict in done.result():
                tell(verdict)
                found.append(verdict)
    return found


def _on_one_rig(
    part: list[Planned], folder: Path, tell: Callable[[Verdict], None] = lambda _: None
) -> list[Verdict]:
    verdicts: list[Verdict] = []
    with serving(folder / f"rig{part[0].number:04d}") as bench:
        for planned in part:
            verdict = _undisturbed(bench, planned)
            tell(verdict)
            verdicts.append(verdict)
    return verdicts


def _moment_s(dice: random.Random) -> float:
    """From the first voltage; an early one is from the program's start, and negative."""
    early, at = dice.random() < EARLY, dice.random()
    return -at * _EARLY_S if early else at * _LATE_S


def _undisturbed(bench: Bench, planned: Planned) -> Verdict:
    """The run; again when it ended before its fault, as on a computer that is too busy."""
    for attempt in range(_TRIES):
        verdict = Verdict(planned.number, planned.fault, planned.after_s, disturbed=attempt)
        try:
            _one(bench, verdict, f"run{planned.number:04d}-{attempt}")
        except DisturbedError as disturbance:
            verdict.faults.append(str(disturbance))
        except Exception as error:  # noqa: BLE001 - the other runs shall be made, and this one seen
            verdict.faults.append(f"{type(error).__name__}: {error}")
            return verdict
        else:
            return verdict
    return verdict


class DisturbedError(Exception):
    """The run was over before anything was done to it."""


def _one(bench: Bench, verdict: Verdict, name: str) -> None:
    relay = Relay(bench.boards) if verdict.fault.needs_relay else None
    world = bench.watch()
    world_begin = len(world.look())
    run = bench.start(name, relay.address if relay else None)
    try:
        _wait_for(verdict, run, world)
        do(verdict.fault, run.process, relay)
        fault_s = time.perf_counter()
        _let_it_end(verdict, run, world)
        _make_safe(verdict, bench)
        rows = world.look()[world_begin:]
        if rows:
            judge_output(verdict, rows, fault_s)
        judge_data(verdict, run.session, rows, fault_s)
    finally:
        _sweep(verdict, run)
        if relay is not None:
            relay.close()
    for path in bench.folder.glob(f"{run.session.stem}*"):
        if not verdict.faults:  # else somebody will want to look
            path.unlink()


def _wait_for(verdict: Verdict, run: LabrigRun, world: WorldRecord) -> None:
    """Until the moment of the fault; DisturbedError when the program did not get there."""
    if verdict.after_s < 0:
        until(lambda: run.has_ended, -verdict.after_s)
    else:
        until(lambda: world.was_energised or run.has_ended, _ENERGISED_S)
        until(lambda: run.has_ended, verdict.after_s)
    if _GUARD in run.said or (run.has_ended and run.process.returncode != 0):
        raise DisturbedError(f"it ended before its fault: {run.said[-300:]}")


def _let_it_end(verdict: Verdict, run: LabrigRun, world: WorldRecord) -> None:
    """Watch what becomes of it; a program that hung goes on, and must find that it may not."""
    until(lambda: run.has_ended and not world.is_energised, _AFTER_S)
    if verdict.fault is Fault.HANG:
        until(lambda: False, _AFTER_S)
        run.process.send_signal(signal.SIGCONT)
    if not until(lambda: run.has_ended, _END_S):
        verdict.faults.append(f"the program did not end in {_END_S:g} s: {run.said[-300:]}")
    verdict.code = run.process.poll()
    if not until(lambda: not run.left_behind(), _GUARD_S):
        verdict.faults.append(f"processes {run.left_behind()} are left")
    if "Traceback" in run.said:
        verdict.faults.append(f"a traceback: {run.said[-1000:]}")


def _make_safe(verdict: Verdict, bench: Bench) -> None:
    """As a person would before the next run; it also reads back what the drive channel says."""
    said = StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        code = labrig(["safe", str(bench.rig_file)])
    if code != 0:
        verdict.faults.append(f"labrig safe ended with {code}: {said.getvalue()[-300:]}")


def _sweep(verdict: Verdict, run: LabrigRun) -> None:
    """Leave nothing behind, whatever the verdict."""
    if not run.has_ended:
        verdict.faults.append("the program had to be killed")
        run.process.kill()
        run.process.wait()
    for pid in run.left_behind():
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
