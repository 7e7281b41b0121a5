"""Makes a whole session of what a crash, a kill or a power cut has left.

The journal is replayed into a new file; what only the session file still holds is added; what is
not whole is left out. The original stays as it is unless asked otherwise.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from labrig.errors import BadInputError, LabrigError
from labrig.session.format import layout
from labrig.session.format.setup import SessionSetup
from labrig.session.notes.add import add_waiting
from labrig.session.notes.stored import add_to_file
from labrig.session.notes.waiting import WaitingNotes, open_waiting
from labrig.session.reading.guard_report import GuardReport, forget_guard_report, read_guard_report
from labrig.session.reading.opening import check_format, check_is_hdf5, recovered_beside
from labrig.session.reading.session import open_session
from labrig.session.reading.values import damage_told, read_setup, read_text
from labrig.session.recording.create import create_file
from labrig.session.recording.disk import written_beside
from labrig.session.recording.journal import JournalReader, journal_path, read_journal
from labrig.session.recording.locking import is_locked
from labrig.session.recording.recorder import MisplacedRowsError, Recorder
from labrig.session.repair.merge import add_missing, copy_supplements, trim
from labrig.session.repair.superblock import unlocked
from labrig.session.repair.verify import verify
from protocols.execution.events import Outcome, OutputState

_CRASHED = "The recording was cut short; this was recovered from what had reached the disk."


@dataclass(frozen=True, kw_only=True)
class RecoverReport:
    """What was found, and what was made of it."""

    source: Path
    output: Path | None  # None: the session was closed, nothing was written
    outcome: Outcome
    from_journal: bool
    runs_completed: int
    readings: int
    samples: int
    frames: int
    notes: tuple[str, ...]  # a sentence each

    @property
    def text(self) -> str:
        """What was saved, in one sentence."""
        if self.output is None:
            return (
                f"{self.source}: was closed, so there is nothing to recover; labrig verify checks "
                "what it holds."
            )
        runs, readings, frames = (
            f"{count} {what}{'' if count == 1 else 's'}"
            for count, what in (
                (self.runs_completed, "run"), (self.readings, "reading"), (self.frames, "frame"),
            )
        )  # fmt: skip
        return f"wrote {self.output}: {self.outcome.value}, {runs} complete, {readings}, {frames}."


def is_left_by_a_crash(path: Path) -> bool:
    """Whether `recover` would find something: a session that nobody records, and not whole."""
    beside = journal_path(path)
    if is_locked(beside) or _is_whole(path):
        return False
    if beside.exists():
        return True
    try:
        check_is_hdf5(path)
    except BadInputError:
        return False
    return True


def recover(path: Path, output: Path | None = None, in_place: bool = False) -> RecoverReport:
    """Write a whole session beside the original (or, `in_place`, instead of it).

    `output` defaults to NAME-recovered.h5. Raises BadInputError when the session is still being
    recorded, when the output exists, or when there is nothing left to recover.
    """
    path = Path(path)
    if output is not None and in_place:
        raise BadInputError("Recover either in place or to another file, not both.")
    beside = journal_path(path)
    if is_locked(beside):
        raise BadInputError(f"{path} is being recorded right now; end that session first.")
    journal = read_journal(beside)
    if _is_whole(path):
        return _nothing_to_do(path, beside, in_place)
    target = path if in_place else (output or recovered_beside(path))
    if target.exists() and not in_place:
        raise BadInputError(f"{target} exists already; choose another name.")
    notes: list[str] = []
    with open_waiting(path) as waiting:
        with written_beside(target) as new:
            with ExitStack() as until:
                old = _open_old(path, journal, until, notes)
                guard = read_guard_report(path)
                _build(new, _setup(path, journal, old), journal, old, guard, notes)
                _add_notes(new, waiting, notes)
            _insist_on_whole(new, target)
        if in_place and waiting is not None:
            waiting.clear()
    if in_place:
        beside.unlink(missing_ok=True)
        forget_guard_report(path)
    return _report(path, target, from_journal=journal is not None, notes=notes)


def _is_whole(path: Path) -> bool:
    try:
        open_session(path).close()
    except BadInputError:
        return False
    return True


def _nothing_to_do(path: Path, journal: Path, in_place: bool) -> RecoverReport:
    notes = []
    if in_place and journal.exists():
        journal.unlink()
        notes.append("Its journal, which it does not need any more, was removed.")
    if in_place and (added := add_waiting(path)):
        notes.append(f"{_counted(added)} from beside it added.")
    return _report(path, None, from_journal=False, notes=notes)


def _open_old(path: Path, journal: JournalReader | None, until: ExitStack, notes: list[str]) -> Any:
    """Return the session file as it stands, or None when only the journal is of use."""
    try:
        check_is_hdf5(path)
        return until.enter_context(unlocked(path))
    except (BadInputError, OSError, RuntimeError) as error:
        if journal is None:
            raise BadInputError(f"nothing to recover (no whole journal): {error}") from None
    notes.append("The session file does not open; everything comes from its journal.")
    return None


def _setup(path: Path, journal: JournalReader | None, old: Any) -> SessionSetup:
    if journal is not None:
        return journal.setup
    with damage_told(path):
        check_format(old, path)
    return read_setup(old, path)


def _build(
    new: Path,
    setup: SessionSetup,
    journal: JournalReader | None,
    old: Any,
    guard: GuardReport | None,
    notes: list[str],
) -> None:
    create_file(new, setup)
    with h5py.File(new, "r+", libver=layout.LIBVER) as file:
        if journal is not None:
            _replay(file, journal, notes)
        if old is not None:
            notes.extend(add_missing(file, old, status_too=journal is None))
            notes.extend(copy_supplements(file, old))
        notes.extend(trim(file, setup))
        _end(file, guard)
        Recorder(file).write_checksums()


def _replay(file: Any, journal: JournalReader, notes: list[str]) -> None:
    recorder = Recorder(file)
    try:
        for rows in journal.rows():
            recorder.apply(rows)
    except (MisplacedRowsError, KeyError, ValueError) as error:
        notes.append(f"The journal was used up to a record that does not fit ({error}).")
    recorder.put()
    left = journal.path.stat().st_size - journal.whole_bytes()
    if left:
        notes.append(f"The last {left} bytes of the journal are no whole record and were left out.")


def _end(file: Any, guard: GuardReport | None) -> None:
    """Mark a session that nobody ended as crashed, its output as the guard reports it."""
    entry = file[layout.ENTRY]
    if entry["outcome"][()] != Outcome.RUNNING.value.encode():
        return
    reason, output = _CRASHED, OutputState.UNKNOWN
    if guard is not None:
        reason = f"{_CRASHED} {guard.text[:1].upper()}{guard.text[1:]}."
        output = OutputState.SAFE if guard.is_safe else OutputState.UNKNOWN
    entry["outcome"][()] = np.bytes_(Outcome.CRASHED.value)
    entry["reason"][()] = np.bytes_(layout.pieces(reason, layout.STATUS_TEXTS["reason"])[0])
    entry["output_state"][()] = np.bytes_(output.value)


def _add_notes(new: Path, waiting: WaitingNotes | None, notes: list[str]) -> None:
    """Add the notes that wait beside the session; those in its file were copied with it."""
    if waiting is None:
        return
    with h5py.File(new, "r+", libver=layout.LIBVER) as file:
        found = waiting.read(read_text(file, f"{layout.ENTRY}/identifier", new))
        if found:
            notes.append(f"{_counted(add_to_file(file, found))} from beside it added.")


def _counted(count: int) -> str:
    return f"{count} note{'' if count == 1 else 's'}"


def _insist_on_whole(new: Path, target: Path) -> None:
    failed = [check for check in verify(new) if not check.ok]
    if failed:
        first = failed[0]
        raise LabrigError(
            f"{target} was not written: what could be recovered is not whole ({first.name}: "
            f"{first.found}). The original is as it was."
        )


def _report(
    path: Path, output: Path | None, *, from_journal: bool, notes: list[str]
) -> RecoverReport:
    with open_session(output or path) as session:
        runs = session.runs
        return RecoverReport(
            source=path,
            output=output,
            outcome=session.outcome,
            from_journal=from_journal,
            runs_completed=sum(run.completed for run in runs),
            readings=sum(len(run.readings) for run in runs),
            samples=sum(run.samples for run in runs),
            frames=sum(run.frame_count for run in runs),
            notes=tuple(notes),
        )
