"""What must be true after a fault, whatever it was."""

from __future__ import annotations

from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.soak import record
from benchmarks.soak.faults import Fault
from benchmarks.soak.rig import LIMIT_V
from labrig.cli.main import run as labrig
from labrig.session import RunRecord, open_session
from labrig.session.format import layout
from labrig.session.recording.journal import journal_path, read_journal
from labrig.session.repair.superblock import unlocked
from protocols.execution.events import Outcome

LONGEST_S = 1.0  # until 0 V, a hang included
STANDS_S = LONGEST_S + 0.6  # that a voltage may be left standing: a pulse, and until 0 V
SETTLED_S = 0.3  # so long after its pulse a reading is in the journal
DRIVE_OFF_V = 0.05  # of a reading, from what the world had: the converter's noise
FORCE_OFF_N = 0.3e-3  # the same of the force: the cell's offset and noise
WINDOW_S = 0.1  # of a reading, on either side
SWING_V, SWING_N = 4.0, 4e-3  # from one pulse to the next
Table = npt.NDArray[np.void]


@dataclass
class Verdict:
    """One run, what was done to it, and all that was not as it should be."""

    number: int
    fault: Fault
    after_s: float  # the moment, from the first voltage (negative: from the program's start)
    zero_s: float | None = None  # from the fault to 0 V; None: it was at 0 V
    largest_V: float = 0.0
    finished: int = 0  # readings whose window was over before the fault
    present: int = 0  # of those that could be read back
    invalid: int = 0  # of those present, as the program itself has marked them (a late edge)
    disturbed: int = 0  # earlier attempts that ended before the fault, on a busy computer
    code: int | None = None  # the program's exit code
    faults: list[str] = field(default_factory=list)

    @property
    def missing(self) -> int:
        """Readings that were over and are not there: the one being taken."""
        return max(0, self.finished - self.present)


def judge_output(verdict: Verdict, rows: list[record.Row], fault_s: float) -> None:
    """Against the record: never beyond the limit, at 0 V in time and for good."""
    verdict.largest_V = max(abs(row.drive_V) for row in rows)
    if verdict.largest_V > LIMIT_V:
        verdict.faults.append(f"{verdict.largest_V:.3f} V at the sheet, the limit is {LIMIT_V} V")
    if rows[-1].is_energised:
        verdict.faults.append(f"{rows[-1].drive_V:.3f} V is left at the sheet")
    if verdict.fault is Fault.JERK:  # it may connect again and go on, to its end or not
        stood = [p for p in record.pulses(rows) if p.end_s - max(p.begin_s, fault_s) > STANDS_S]
        if stood:
            verdict.faults.append(f"{stood[0].volts:.3f} V stood for more than {STANDS_S} s")
        return
    if verdict.fault is Fault.HANG and not was_energised(rows, fault_s):
        return  # it was not in the guard's care; awake again it may go on
    verdict.zero_s = record.zero_since(rows, fault_s)
    if verdict.zero_s is not None and verdict.zero_s > LONGEST_S:
        verdict.faults.append(f"0 V only after {verdict.zero_s:.3f} s")
    at_rest = not was_energised(rows, fault_s)
    if at_rest and any(row.is_energised and row.time_s > fault_s for row in rows):
        verdict.faults.append("a voltage after the fault, at which the sheet was at 0 V")


def was_energised(rows: list[record.Row], time_s: float) -> bool:
    """Whether there was a voltage at a moment."""
    return abs(record.volts_at(rows, time_s)) > record.ZERO_V


def judge_data(verdict: Verdict, session: Path, rows: list[record.Row], fault_s: float) -> None:
    """What the program left, made whole by `labrig recover`, against what it had and the world."""
    if not session.exists():
        if any(row.is_energised for row in rows):
            verdict.faults.append("there was a voltage, and there is no session file")
        return
    held = [*_of_journal(session), *_of_live_file(session)]
    whole = _recovered(verdict, session)
    if whole is None:
        return
    with open_session(whole) as opened:
        runs = opened.runs
        if verdict.fault.is_deadly and opened.outcome not in (Outcome.CRASHED, Outcome.COMPLETED):
            verdict.faults.append(f"the outcome of a killed session is {opened.outcome.value}")
        for run, table in held:
            _compare_with(verdict, runs[run], table)
        _compare_with_world(verdict, [run for run in runs if run.started], rows, fault_s)


def _of_journal(session: Path) -> list[tuple[int, Table]]:
    """The readings in the journal, run by run, read without what `recover` does with them."""
    journal = read_journal(journal_path(session))
    found: dict[str, list[Table]] = {}
    if journal is None:
        return []
    row = journal.setup.reading_row
    for part in journal.rows():
        if part.path.endswith("/readings"):
            found.setdefault(part.path, []).append(np.frombuffer(part.blob, row))
    return [(_run_of(path), np.concatenate(parts)) for path, parts in found.items()]


def _of_live_file(session: Path) -> list[tuple[int, Table]]:
    """Those in the file as the program left it."""
    found: list[tuple[int, Table]] = []
    with suppress(OSError, RuntimeError, KeyError), unlocked(session) as file:
        names = [name for name in file[layout.ENTRY] if name.startswith("run_")]
        for name in names:
            table = file[f"{layout.ENTRY}/{name}/readings"][()]
            found.append((_run_of(name), table))
    return found


def _run_of(path: str) -> int:
    return int(path.rpartition("run_")[2].partition("/")[0])


def _recovered(verdict: Verdict, session: Path) -> Path | None:
    """The whole session by the command line; the original where that is whole."""
    target = session.with_suffix(".whole.h5")
    said = StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        code = labrig(["recover", str(session), "-o", str(target)])
        whole = target if target.exists() else session
        if code == 0:
            code = labrig(["verify", str(whole)])
    if code != 0:
        verdict.faults.append(f"recover or verify ended with {code}: {said.getvalue()[-300:]}")
        return None
    return whole


def _compare_with(verdict: Verdict, run: RunRecord, held: Table) -> None:
    """Nothing that the journal or the live file had may be gone or other."""
    have = run.readings
    if len(have) < len(held):
        verdict.faults.append(
            f"run {run.planned.index}: {len(held)} readings had been recorded, "
            f"{len(have)} were recovered"
        )
    for name in ("index", "time_s", "force_N", "drive_V", "current_A", "valid"):
        count = min(len(have), len(held))
        if not np.array_equal(
            have[name][:count], held[name][:count], equal_nan=have[name].dtype.kind == "f"
        ):
            verdict.faults.append(f"run {run.planned.index}: {name} of readings was changed")


def _compare_with_world(
    verdict: Verdict, runs: list[RunRecord], rows: list[record.Row], fault_s: float
) -> None:
    """Each pulse that was over has its reading, and each reading is what the world was like."""
    verdict.present = sum(len(run.readings) for run in runs)
    begun = [run.time_zero_s for run in runs]
    over = [pulse for pulse in record.pulses(rows) if pulse.end_s < fault_s]
    settled = [pulse for pulse in over if pulse.end_s < fault_s - SETTLED_S]
    verdict.finished = len(over) + _zero_readings(begun, over)
    certain = len(settled) + _zero_readings(begun, settled)
    if verdict.present < certain:  # what was over later may be gone
        verdict.faults.append(
            f"{verdict.finished} readings were over, {certain} for more than {SETTLED_S} s; "
            f"{verdict.present} are there"
        )
    for run in runs:
        for row in run.readings[run.readings["valid"]]:
            _compare_reading(verdict, run, row, rows)
        verdict.invalid += int((~run.readings["valid"]).sum())


def _zero_readings(begun: list[float], over: list[record.Pulse]) -> int:
    """One for each run of which a pulse is over."""
    ends = [*begun[1:], float("inf")][: len(begun)]
    return sum(
        any(begin <= pulse.begin_s < end for pulse in over)
        for begin, end in zip(begun, ends, strict=True)
    )


def _compare_reading(
    verdict: Verdict, run: RunRecord, row: np.void, rows: list[record.Row]
) -> None:
    at_s = run.time_zero_s + float(row["time_s"])
    name = f"run {run.planned.index}, reading {int(row['index'])}"
    volts = record.volts_at(rows, at_s)
    # A clock that is not known better mixes the edge of the next pulse into the reading's window.
    unsure = run.sample_clock.start_uncertainty_s / WINDOW_S
    if not abs(float(row["drive_V"]) - volts) < DRIVE_OFF_V + SWING_V * unsure:
        verdict.faults.append(f"{name}: {row['drive_V']:.3f} V, the world had {volts:.3f} V")
    force_N = record.force_between(rows, at_s - WINDOW_S, at_s + WINDOW_S) if volts else None
    if (
        force_N is not None
        and not abs(float(row["force_N"]) - force_N) < FORCE_OFF_N + SWING_N * unsure
    ):
        verdict.faults.append(
            f"{name}: {1e3 * row['force_N']:.3f} mN, the world had {1e3 * force_N:.3f} mN"
        )
