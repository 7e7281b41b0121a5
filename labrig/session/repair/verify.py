"""Whether a session file holds what it should, unchanged since it was closed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from labrig.check import Check
from labrig.errors import BadInputError
from labrig.session.annotations.stored import changed
from labrig.session.derived.store import derived_digest
from labrig.session.format import layout
from labrig.session.reading.opening import open_file
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.session import RecordedSession
from labrig.session.reading.values import damage_told, dataset_names, read_dataset, read_table
from labrig.session.recording.recorder import digest
from protocols.execution.events import Outcome


def verify(path: Path) -> list[Check]:
    """All checks of a session file; the first is whether it opens at all. Changes nothing."""
    path = Path(path)
    try:
        file = open_file(path)
    except BadInputError as error:
        return [Check(name="opens", ok=False, found=str(error), wanted="a session that was closed")]
    with file:
        checks = [Check(name="opens", ok=True, found="a closed session", wanted="a closed session")]
        try:
            session = RecordedSession(file, path)
            checks.append(_outcome(session))
            checks.extend(_checksums(file, path))
            for run in session.runs:
                checks.extend(_run(run, session))
        except BadInputError as error:
            checks.append(Check(name="structure", ok=False, found=str(error), wanted="readable"))
    return checks


def _outcome(session: RecordedSession) -> Check:
    found = session.outcome
    return Check(
        name="outcome",
        ok=found is not Outcome.RUNNING,
        found=found.value,
        wanted="how the session ended",
    )


def _checksums(file: Any, path: Path) -> Iterator[Check]:
    stored = {
        str(row["dataset"]): str(row["sha256"])
        for row in read_table(file, layout.CHECKSUMS, layout.CHECKSUM_ROW, path)
    }
    added = (f"{layout.DERIVED}/", f"{layout.ANNOTATIONS}/")
    raw = {name for name in dataset_names(file, path) if not name.startswith(added)}
    extra = sorted(raw - set(stored) - {layout.CHECKSUMS})
    if extra:
        yield Check(
            name="datasets", ok=False, found=", ".join(extra), wanted="none beyond the layout"
        )
    changed = [name for name, wanted in stored.items() if _digest(file, name, path) != wanted]
    found = f"{len(stored) - len(changed)} of {len(stored)} datasets unchanged"
    if changed:
        found += f"; changed: {', '.join(changed)}"
    yield Check(
        name="checksums", ok=not changed, found=found, wanted=f"{len(stored)} datasets unchanged"
    )
    if layout.DERIVED in file:
        yield _derived(file, path)
    if layout.ANNOTATIONS in file:
        yield _annotations(file, path)


def _annotations(file: Any, path: Path) -> Check:
    count, faults = changed(file, path)
    found = f"{count - len(faults)} of {count} as they were added"
    if faults:
        found += f"; changed: {', '.join(faults)}"
    return Check(name="annotations", ok=not faults, found=found, wanted="each as it was added")


def _derived(file: Any, path: Path) -> Check:
    with damage_told(path, layout.DERIVED):
        group = file[layout.DERIVED]
        stored = group.attrs.get("sha256")
        ok = isinstance(stored, bytes) and stored.decode("ascii", "replace") == derived_digest(
            group
        )
    found = "unchanged" if ok else "changed since they were stored; run labrig analyze again"
    return Check(name="derived measurements", ok=ok, found=found, wanted="unchanged")


def _digest(file: Any, name: str, path: Path) -> str:
    try:
        return digest(read_dataset(file, name, path))
    except (OSError, RuntimeError, BadInputError):
        return "unreadable"


def _run(run: RunRecord, session: RecordedSession) -> Iterator[Check]:
    name = f"run {run.planned.index + 1}"
    whole = session.outcome is Outcome.COMPLETED or run.completed
    planned, have = len(run.planned.readings), len(run.readings)
    cut = "" if whole else f" (the session {session.outcome.value})"
    ok = have == planned or not whole
    yield Check(
        name=f"{name}: readings", ok=ok, found=f"{have} of {planned}{cut}", wanted=f"{planned}"
    )
    if whole and run.planned.readings:
        least = int(run.planned.duration_s * run.sample_clock.rate_hz)
        yield Check(
            name=f"{name}: samples",
            ok=run.samples >= least,
            found=f"{run.samples}",
            wanted=f"at least {least}",
        )
    yield _frames(run, name)


def _frames(run: RunRecord, name: str) -> Check:
    rows = run.readings["frame"]
    astray = int((rows >= run.frame_count).sum())
    found = f"{run.frame_count} frames" + (f", {astray} of readings missing" if astray else "")
    return Check(
        name=f"{name}: frames",
        ok=astray == 0,
        found=found,
        wanted="the frame of each reading that has one",
    )
