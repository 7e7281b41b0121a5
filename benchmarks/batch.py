"""`labrig batch`: the same results as one by one, nothing lost by kills, and what the loop costs.

    python -m benchmarks batch

Fits are of sessions simulated at one position, 0.1 s of CPU each. CPU times are those of all
processes; wall times are not compared.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import math
import os
import random
import resource
import signal
import tempfile
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from benchmarks._batch_tasks import Costless, planned, write_model
from benchmarks.report import Report, Table, busy
from labrig.batch.plan import ROWS, BatchPlan
from labrig.batch.rows import PieceOutcome, Row, rows_in
from labrig.batch.run import one_by_one, run_batch
from labrig.batch.summary.write import write_summary
from labrig.batch.tasks.simulate import CoverageStudy
from labrig.batch.workers import local_workers

FITS = int(os.environ.get("BATCH_FITS", "1000"))
KILLED_FITS, KILL_SHARE = 120, 0.15  # of the rows, after which a worker is killed
KILLED_COSTLESS = 2_000
SIZES = (10, 100, 1_000, 10_000)


@dataclass(frozen=True)
class Spent:
    """CPU time of this process, and of those that it started and that have ended."""

    own_s: float
    children_s: float

    @classmethod
    def now(cls) -> Spent:
        def both(who: int) -> float:
            used = resource.getrusage(who)
            return used.ru_utime + used.ru_stime

        return cls(both(resource.RUSAGE_SELF), both(resource.RUSAGE_CHILDREN))

    def since(self, before: Spent) -> Spent:
        return Spent(self.own_s - before.own_s, self.children_s - before.children_s)

    @property
    def whole_s(self) -> float:
        return self.own_s + self.children_s


def batch(plan: BatchPlan, workers: int, kill_share: float = 0.0) -> tuple[Spent, int]:
    """Do a plan, now and then killing a worker; the CPU time it took, and the kills."""
    dice, kills = random.Random(7), 0

    def perhaps_kill(*_: object) -> None:
        nonlocal kills
        pids = them.executor.pids
        if pids and dice.random() < kill_share:
            with suppress(ProcessLookupError):
                os.kill(dice.choice(pids), signal.SIGKILL)
                kills += 1

    before = Spent.now()
    with local_workers(workers) as them:
        run_batch(plan, them.executor, them.places, perhaps_kill)
    return Spent.now().since(before), kills


def rows_of(plan: BatchPlan) -> list[Row]:
    return list(rows_in(plan.folder / ROWS))


def lost_and_doubled(plan: BatchPlan) -> tuple[int, int]:
    """Names without a row that is done, and rows beyond the first of a name."""
    rows = rows_of(plan)
    done = {row.name for row in rows if row.outcome is PieceOutcome.DONE}
    counts = Counter(row.name for row in rows)
    return len(set(plan.names) - done), sum(count - 1 for count in counts.values())


def same_results(folder: Path, model: Path) -> tuple[list[tuple[str, ...]], dict[str, float]]:
    """Fit the same sessions one by one, and by two workers."""
    task = CoverageStudy(count=FITS, position_mm=(10.0,), readings=4)
    task.warm_up()
    alone_plan = planned(task, model, folder / "alone")
    before = Spent.now()
    alone = {row.name: row.digest for row in one_by_one(alone_plan.todo)}
    work_s = Spent.now().since(before).whole_s
    plan = planned(task, model, folder / "two")
    spent, _ = batch(plan, 2)
    rows = rows_of(plan)
    differing = sum(alone[row.name] != row.digest for row in rows)
    in_tasks_s = sum(row.cpu_s for row in rows)
    lost, doubled = lost_and_doubled(plan)
    figures = {
        "fits": FITS, "differing": differing, "lost": lost, "doubled": doubled,
        "different_digests": len(set(alone.values())), "alone_s": work_s,
        "two_workers_s": spent.whole_s, "in_tasks_s": in_tasks_s,
        "overhead": spent.whole_s / in_tasks_s - 1.0, "ratio": spent.whole_s / work_s,
        "parent_share": spent.own_s / in_tasks_s,
    }  # fmt: skip
    rows_out = [
        ("fits, each of another session", f"{FITS}"),
        ("different digests among them", f"{figures['different_digests']}"),
        ("digests that differ from one by one", f"{differing}"),
        ("rows lost, doubled", f"{lost}, {doubled}"),
        ("CPU one by one", f"{work_s:.1f} s"),
        ("CPU of two workers and their parent", f"{spent.whole_s:.1f} s"),
        ("the latter over the former", f"{figures['ratio']:.3f}"),
        ("CPU beyond that inside the tasks", f"{100 * figures['overhead']:.1f} %"),
        ("of which the parent's", f"{100 * figures['parent_share']:.2f} %"),
    ]
    return rows_out, figures


def killed(folder: Path, model: Path) -> tuple[list[tuple[str, ...]], dict[str, float]]:
    """Kill workers while they fit, and while they do nothing much."""
    rows, figures = [], {}
    fits = CoverageStudy(count=KILLED_FITS, position_mm=(10.0,), readings=4)
    for name, task, share in (
        ("fits", fits, KILL_SHARE),
        ("costless", Costless(count=KILLED_COSTLESS), 0.05),
    ):
        plan = planned(task, model, folder / f"killed-{name}")
        _, kills = batch(plan, 2, share)
        lost, doubled = lost_and_doubled(plan)
        rows.append((name, str(len(plan.names)), str(kills), str(lost), str(doubled)))
        figures |= {f"{name}_kills": kills, f"{name}_lost": lost, f"{name}_doubled": doubled}
    return rows, figures


def growth(folder: Path, model: Path) -> tuple[list[tuple[str, ...]], dict[str, float]]:
    """Plan, do and sum up more and more pieces that cost nothing."""
    rows, spent, peaks = [], {}, {}
    for count in SIZES:
        task = Costless(count=count)
        before = Spent.now()
        plan = planned(task, model, folder / f"growth-{count}")
        batch(plan, 2)
        write_summary(plan.folder, plan.names, task)
        spent[count] = Spent.now().since(before).whole_s
        peaks[count] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        each = 1e3 * spent[count] / count
        rows.append((str(count), f"{spent[count]:.2f}", f"{each:.2f}", f"{peaks[count]:.0f}"))
    first, *_, before_last, last = SIZES
    figures = {
        "exponent": math.log(spent[last] / spent[first]) / math.log(last / first),
        "exponent_of_the_large_end": math.log(spent[last] / spent[before_last])
        / math.log(last / before_last),
        "peak_MB": peaks[last],
        "cpu_per_piece_s": (spent[last] - spent[first]) / (last - first),
    }
    return rows, figures


def measure() -> Report:
    """All of it; about five minutes of CPU."""
    note = busy()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        model = write_model(folder / "model.toml")
        grown, how_grown = growth(folder, model)
        kills, how_killed = killed(folder, model)
        same, how_same = same_results(folder, model)
    columns = ("pieces", "CPU s", "ms a piece", "parent's largest memory, MB")
    return Report(
        tables=(
            Table("The same as one by one", ("", "found"), tuple(same)),
            Table("Killed", ("pieces of", "all", "kills", "lost", "doubled"), tuple(kills)),
            Table("Growth, with a task that costs nothing", columns, tuple(grown)),
        ),
        figures={"same": how_same, "killed": how_killed, "growth": how_grown},
        notes=(*_grown(how_grown), note),
    )


def _grown(figures: dict[str, float]) -> tuple[str, str]:
    whole, end = figures["exponent"], figures["exponent_of_the_large_end"]
    each_ms = 1e3 * figures["cpu_per_piece_s"]
    return (
        f"CPU grows with the pieces to the power of {whole:.2f}, at the large end {end:.2f}",
        f"a piece costs {each_ms:.2f} ms of CPU beside its work",
    )
