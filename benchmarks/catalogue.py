"""The catalogue of 100 000 sessions: search, first page, four programs that write at once.

    python -m benchmarks catalogue

Times are medians of CPU time in one process; entries are made up, none of their files is opened.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median

from benchmarks.report import Report, Table, busy
from labrig.library import CatalogueEntry, SessionQuery
from labrig.library.cache_folder import OWN
from labrig.library.database import Database
from labrig.library.fits import ModelFits
from labrig.library.records import choose_fits, put_entry, put_model
from labrig.library.select import select

SESSIONS = 100_000
WRITERS, EACH = 4, 5_000
REPEATS = 25
CHUNK = 500  # entries in one transaction, as Library does
_WORDS = ("nafion", "flemion", "aged", "fresh", "bubble", "clamp", "humid", "Ada", "Ben", "Cleo")


def made(count: int, seed: int = 0) -> Iterator[tuple[CatalogueEntry, ModelFits | None]]:
    """Sessions as a lab would have them; every third was fitted."""
    dice = random.Random(seed)
    for k in range(count):
        checksum = f"{seed:02d}{k:062d}"
        entry = CatalogueEntry(
            name=f"{2020 + k % 7}/{k % 365:03d}/session-{seed}-{k:06d}.h5",
            bytes=dice.randrange(10**6, 10**8),
            started=f"{2020 + k % 7}-{1 + k % 12:02d}-{1 + k % 28:02d}T{k % 24:02d}:{k % 60:02d}",
            sheet=("long", "short") if k % 2 else ("long",),
            protocol="pulse_train",
            outcome="completed" if k % 9 else "aborted",
            runs=14,
            runs_complete=14,
            readings=448,
            largest_force_mN=dice.uniform(0.1, 3.0),
            scatter_mN=dice.uniform(0.01, 0.1),
            checksum=checksum,
            sample=f"S-{k % 400}",
            operators=("Ada Example",),
            words=" ".join(dice.choices(_WORDS, k=12)),
            notes=1,
        )
        fit = {
            "B_Nm2": dice.gauss(1.2e-6, 1e-7), "E_Pa": 1e8, "EIBM_Nm": {"2.0": 3e-5},
            "EIBM_quantity": "constant EIBM", "rmse_force_mN": 0.1, "rmse_curve_mm": 0.1,
        }  # fmt: skip
        yield entry, ModelFits(checksum, "constant", {"long": fit}) if k % 3 == 0 else None


def fill(database: Database, count: int, seed: int = 0) -> None:
    """Put them in, in transactions of `CHUNK` entries."""
    chunk = []
    for one in made(count, seed):
        chunk.append(one)
        if len(chunk) == CHUNK:
            _put(database, chunk)
            chunk = []
    _put(database, chunk)


def _put(database: Database, chunk: list[tuple[CatalogueEntry, ModelFits | None]]) -> None:
    def put(connection):
        ids = [put_entry(connection, entry) for entry, _ in chunk]
        for entry, fits in chunk:
            if fits is not None:
                put_model(connection, f"{entry.name}.toml", 1, fits)
        choose_fits(connection, ids, ())

    database.write(put)


QUESTIONS = {
    "first page of 100, newest first": SessionQuery(limit=100),
    "first page of 100, by B": SessionQuery(sort="B_Nm2", limit=100),
    "first page of 100, by name": SessionQuery(sort="name", down=False, limit=100),
    "first page of 100, by a column without an index": SessionQuery(sort="duration_s", limit=100),
    "page 500, newest first": SessionQuery(limit=100, offset=49_900),
    "search: a word of one session": SessionQuery(text="session-0-031415", limit=100),
    "search: a word of most sessions": SessionQuery(text="nafion", limit=100),
    "search: three words": SessionQuery(text="nafion bubble s-17", limit=100),
    "search: no session has it": SessionQuery(text="unheard", limit=100),
    "one outcome": SessionQuery(outcome="aborted", limit=100),
    "one sheet, one outcome, a word": SessionQuery(
        sheet="short", outcome="aborted", text="aged", limit=100
    ),
}


def cpu_s(ask: Callable[[], object]) -> list[float]:
    """CPU time of each of some calls."""
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        ask()
        times.append(time.process_time() - began)
    return times


def write_at_once(folder: Path) -> tuple[int, int]:
    """Let several programs write; how many failed, and how many sessions are there then."""
    command = [sys.executable, "-m", "benchmarks.catalogue", str(folder)]
    programs = [
        subprocess.Popen([*command, str(seed)], cwd=Path(__file__).parents[1])
        for seed in range(1, WRITERS + 1)
    ]
    failed = sum(program.wait() != 0 for program in programs)
    database = Database(folder)
    there = database.read(lambda c: c.execute("SELECT count(*) FROM sessions").fetchone()[0])
    database.close()
    return failed, there


def measure() -> Report:
    """Fill a catalogue, ask it, and let others write into another one."""
    note = busy()
    with tempfile.TemporaryDirectory() as temporary:
        os.environ[OWN] = temporary
        folder = Path(temporary) / "data"
        folder.mkdir()
        database = Database(folder)
        began = time.process_time()
        fill(database, SESSIONS)
        filled_s = time.process_time() - began
        rows, figures = [], {"fill_s": filled_s, "bytes": database.path.stat().st_size}
        for name, wanted in QUESTIONS.items():
            found = database.read(lambda c, wanted=wanted: select(c, wanted))
            times = cpu_s(lambda wanted=wanted: database.read(lambda c: select(c, wanted)))
            figures[name] = median(times)
            rows.append(
                (name, str(found.total), f"{1e3 * median(times):.1f}", f"{1e3 * max(times):.1f}")
            )
        database.close()
        other = Path(temporary) / "other"
        other.mkdir()
        failed, there = write_at_once(other)
    figures |= {"failed_writers": failed, "written": there}
    return Report(
        tables=(
            Table(
                f"Catalogue of {SESSIONS} sessions, CPU time of {REPEATS} calls",
                ("question", "fit", "median ms", "largest ms"),
                tuple(rows),
            ),
        ),
        figures=figures,
        notes=(_filled(figures), _written(figures), note),
    )


def _filled(figures: dict[str, float]) -> str:
    took, size = figures["fill_s"], figures["bytes"]
    each = 1e6 * took / SESSIONS
    return (
        f"to fill it took {took:.0f} s of CPU, {each:.0f} µs a session; it has {size / 1e6:.0f} MB"
    )


def _written(figures: dict[str, float]) -> str:
    return (
        f"{WRITERS} programs that each put {EACH} sessions in at once: "
        f"{figures['failed_writers']} failed, {figures['written']} of {WRITERS * EACH} are there"
    )


def write() -> None:
    """One of several programs that write."""
    folder, seed = Path(sys.argv[1]), int(sys.argv[2])
    database = Database(folder)
    fill(database, EACH, seed)
    if database.path is None:
        raise SystemExit("the catalogue is in memory")
    database.close()


if __name__ == "__main__":
    write()
