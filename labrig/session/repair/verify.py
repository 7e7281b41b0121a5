"""Whether a session file holds what it should, unchanged since it was closed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from labrig.check import Check
from labrig.errors import BadInputError
from labrig.session.format import layout
from labrig.session.format.checksums import ATTRIBUTES_SINCE, covered, digest, version_of
from labrig.session.marks.stored import chain_holds
from labrig.session.reading.opening import open_file
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.session import RecordedSession
from labrig.session.reading.values import damage_told, read_array, read_dataset, read_table
from labrig.session.supplements.store import is_sealed
from protocols.execution.events import Outcome

_SUPPLEMENTS = {
    layout.DERIVED: ("derived measurements", "; run labrig analyze again"),
    layout.NOTES: ("notes", ""),
}


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
            checks.extend(_supplements(file, path))
            checks.extend(_marks(session, file, path))
            checks.extend(_times(file, path))
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
    with damage_told(path):
        items = covered(file)
        own = list(file[layout.CHECKSUMS].attrs)
    extra = sorted(items.keys() - stored.keys())
    extra += [f"{layout.CHECKSUMS}@{name}" for name in own]
    if extra:
        yield Check(
            name="datasets", ok=False, found=", ".join(extra), wanted="none beyond the layout"
        )
    version = version_of(file)
    changed = [name for name, sha in stored.items() if _digest(items.get(name), version) != sha]
    what = "datasets" if version < ATTRIBUTES_SINCE else "groups and datasets"
    found = f"{len(stored) - len(changed)} of {len(stored)} {what} unchanged"
    if changed:
        found += f"; changed: {', '.join(changed)}"
    yield Check(
        name="checksums", ok=not changed, found=found, wanted=f"{len(stored)} {what} unchanged"
    )


def _supplements(file: Any, path: Path) -> Iterator[Check]:
    for name, (title, remedy) in _SUPPLEMENTS.items():
        if name not in file:
            continue
        with damage_told(path, name):
            ok = is_sealed(file[name])
        found = "unchanged" if ok else f"changed since they were stored{remedy}"
        yield Check(name=title, ok=ok, found=found, wanted="unchanged")


def _marks(session: RecordedSession, file: Any, path: Path) -> Iterator[Check]:
    if layout.MARKS not in file:
        return
    with damage_told(path, layout.MARKS):
        ok = is_sealed(file[layout.MARKS]) and chain_holds(file, path, session.checksum)
    found = "unchanged" if ok else "changed since they were made"
    yield Check(name="marks after the end", ok=ok, found=found, wanted="unchanged")


def _times(file: Any, path: Path) -> Iterator[Check]:
    """Warn of readings without a time in the columns of all readings; their runs have the times.

    Those of copied runs have NaN in sessions that an older labrig resumed.
    """
    name = layout.scan_path("time_s")
    with damage_told(path, name):
        if name not in file:
            return
    times = read_array(read_dataset(file, name, path), path)
    if times.dtype.kind != "f":  # changed since: its checksum says so
        return
    unknown = int((~np.isfinite(times)).sum())
    if unknown:
        found = f"{unknown} of {len(times)} readings have none in {name}; their runs have"
        yield Check(name="times", ok=True, found=found, wanted="finite", warning=True)


def _digest(item: Any, version: int) -> str:
    try:
        return "missing" if item is None else digest(item, version)
    except (OSError, RuntimeError, ValueError):
        return "unreadable"


def _run(run: RunRecord, session: RecordedSession) -> Iterator[Check]:
    extra = run.planned.extra
    name = f"run {run.planned.index + 1}" + (f", {extra}" if extra else "")
    whole = session.outcome is Outcome.COMPLETED or run.completed
    planned, have = len(run.planned.readings), len(run.readings_as_taken)
    cut = "" if whole else f" (the session {session.outcome.value})"
    ok = have == planned or not whole
    yield Check(
        name=f"{name}: readings", ok=ok, found=f"{have} of {planned}{cut}", wanted=f"{planned}"
    )
    if whole and (run.planned.readings or extra):
        least = int(run.planned.duration_s * run.sample_clock.rate_hz)
        yield Check(
            name=f"{name}: samples",
            ok=run.samples >= least,
            found=f"{run.samples}",
            wanted=f"at least {least}",
        )
    yield _frames(run, name)


def _frames(run: RunRecord, name: str) -> Check:
    rows = run.readings_as_taken["frame"]
    astray = int((rows >= run.frame_count).sum())
    found = f"{run.frame_count} frames" + (f", {astray} of readings missing" if astray else "")
    every = run.planned.keep_all_frames and run.completed
    if every:
        found += f" of {run.counts.frames_grabbed} that came"
    return Check(
        name=f"{name}: frames",
        ok=astray == 0 and not (every and run.frame_count == 0),
        found=found,
        wanted="every frame" if every else "the frame of each reading that has one",
    )
