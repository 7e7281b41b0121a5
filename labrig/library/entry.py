"""What a list of sessions shows of one of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from labrig.errors import LabrigError
from labrig.library.conditions import (
    condition_means,
    imported_conditions,
    largest_force_mN,
    median_scatter_mN,
)
from labrig.library.fits import Fits
from labrig.serialise import to_plain
from labrig.session import Note, RecordedSession, open_session


@dataclass(frozen=True, kw_only=True)
class CatalogueEntry:
    """One file. `name` is its path in the folder, with slashes. A damaged one has `error` only."""

    name: str
    bytes: int = 0
    error: str | None = None
    started: str = ""
    sheet: tuple[str, ...] = ()
    protocol: str = ""
    outcome: str = ""
    output: str = ""
    reason: str = ""
    simulated: bool = False
    boards: str = ""  # simulated, real, not known, or of each by name
    runs: int = 0
    runs_complete: int = 0
    readings: int = 0
    invalid: int = 0
    duration_s: float | None = None  # by the session's own clock
    clock: str = ""  # real or virtual
    analysed: bool = False
    largest_force_mN: float | None = None
    scatter_mN: float | None = None
    checksum: str = ""  # of the recording with its marks
    earlier_checksums: tuple[str, ...] = ()  # of the same before marks were made after the end
    marks: int = 0  # made after the end, or taken back
    analysis_outdated: bool = False  # made before the last of them
    fit_outdated: bool = False
    title: str = ""
    project: str = ""
    sample: str = ""  # its identity
    operators: tuple[str, ...] = ()
    notes: int = 0
    words: str = ""  # to be searched: all that is stated of people and sample, and the notes
    fit: Fits | None = None

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        plain: dict[str, Any] = to_plain(self)
        del plain["words"]
        return plain

    def fitted(self, what: str) -> float | None:
        """B_Nm2, E_Pa or EIBM_Nm (the largest) of the first configuration that was fitted."""
        for one in (self.fit or {}).values():
            value = one.get(what)
            if isinstance(value, dict):
                sizes = [abs(moment) for moment in value.values() if moment is not None]
                value = max(sizes, default=None)
            if value is not None:
                return float(value)
        return None


def read_entry(path: Path, name: str) -> CatalogueEntry:
    """Look into a session; samples and images are not read. Never raises for what is in a file."""
    bare = CatalogueEntry(name=name)
    try:
        bare = replace(bare, bytes=path.stat().st_size)
        with open_session(path, live=True) as session:
            return _entry(session, bare)
    except LabrigError as error:
        told = str(error).removeprefix(f"{path}: ")
        return replace(bare, error=told.replace(str(path), name))
    except OSError as error:
        return replace(bare, error=f"cannot be read ({error.strerror or error}).")


def _entry(session: RecordedSession, bare: CatalogueEntry) -> CatalogueEntry:
    means = condition_means(session)
    begun = [run for run in session.runs if run.started]
    names = dict.fromkeys(run.planned.configuration for run in session.runs)
    readings = [run.readings for run in begun]
    tables = imported_conditions(session)
    imported = [one for each in tables for one in each.readings]
    whole = session.was_closed
    about, notes = session.about, session.notes
    return replace(
        bare,
        started=session.started,
        sheet=tuple(names or dict.fromkeys(one.configuration for one in tables)),
        protocol=session.schedule.protocol,
        outcome=session.outcome.value,
        output=session.output_state.value,
        reason=session.reason,
        simulated=session.simulated,
        boards=session.boards,
        runs=len(session.runs),
        runs_complete=sum(run.completed for run in session.runs),
        readings=sum(len(rows) for rows in readings) + len(imported),
        invalid=sum(int((~rows["valid"]).sum()) for rows in readings)
        + sum(not one.valid for one in imported),
        duration_s=session.duration_s,
        clock=session.clock,
        analysed=session.has_measurements,
        largest_force_mN=largest_force_mN(means),
        scatter_mN=median_scatter_mN(means),
        checksum=session.data_checksum if whole else "",
        earlier_checksums=_earlier(session) if whole else (),
        marks=len(session.marks_after_end),
        analysis_outdated=bool(session.outdated),
        title=about.title,
        project=about.project,
        sample=about.sample.identity if about.sample else "",
        operators=about.operators,
        notes=len(notes),
        words=" ".join((*_texts_in(about.model_dump(mode="json")), *map(_words_of, notes))),
    )


def _texts_in(value: Any) -> Iterator[str]:
    """Yield all texts of plain JSON."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _texts_in(item)


def _words_of(note: Note) -> str:
    return f"{note.who} {note.text} {note.file_name}"


def _earlier(session: RecordedSession) -> tuple[str, ...]:
    """Return the checksums that the data had, but for the present one."""
    now = session.data_checksum
    return tuple(dict.fromkeys(each for each in session.data_checksums if each != now))
