"""Sessions made of CSV files, and CSV files made of sessions."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from labrig.config import file_kinds, parse_about, parse_sheet, read_text
from labrig.config.about import FILE as ABOUT
from labrig.config.file_kinds import SHEET
from labrig.errors import BadInputError
from labrig.files import all_or_none, check_session_name
from labrig.session.derived.store import load_measurements, write_derived
from labrig.session.format import layout
from labrig.session.format.setup import IMPORTED_FRAME_RATE_HZ, SessionSetup
from labrig.session.notes.export import check_free, file_names, write_about_and_notes
from labrig.session.reading.session import open_session
from labrig.session.recording.create import fill_file
from labrig.session.recording.disk import written_beside
from labrig.session.recording.recorder import Recorder
from labrig.session.tables.control_table import FILE as CONTROL
from labrig.session.tables.control_table import check_no_control, write_control
from labrig.session.tables.csv_rows import TextTable
from labrig.session.tables.preview import in_one_line
from labrig.session.tables.read import read_and_understood
from labrig.session.tables.text.meaning import AS_NAMED, ColumnNames
from labrig.session.tables.write import TABLES, write_tables
from model.measurements import Measurements
from protocols.execution.events import Outcome
from protocols.planning.schedule import Schedule

Agree = Callable[[Sequence[TextTable]], None]
IMPORTED = "import"  # the name of the protocol of a session that was not recorded


def import_session(
    sheet: Path,
    forces: Path | None,
    output: Path,
    *,
    curves: Path | None = None,
    signals: Path | None = None,
    about: Path | None = None,
    names: ColumnNames = AS_NAMED,
    agree: Agree | None = None,
) -> Measurements:
    """Make a session of tables: measurements without anything raw.

    Without `forces` it holds the curves alone. A camera_uncertainty.csv beside the curves is read
    with them. `about` is by default the about.toml in the folder of forces.csv or curves.csv, where
    there is one. `names` says what columns of other names mean. `agree` is called with the tables
    as they were understood, before anything is written; it raises an error where somebody does not
    agree.

    Raises BadInputError for a fault in a file (naming it, the line and the column) and when the
    output exists.
    """
    output = Path(output)
    check_session_name(output)
    text = read_text(sheet, SHEET)
    geometry = parse_sheet(text, str(sheet))
    read = read_and_understood(geometry, forces, curves, signals, names=names)
    stated = about_text(about, Path(forces or curves or sheet))
    tables = {f"{table.kind}.csv": table.path for table in read.tables}
    sums = {name: _checksum(path) for name, path in tables.items()}
    measurements = replace(read.measurements, checksum=next(iter(sums.values())))
    if output.exists():
        raise BadInputError(f"{output} exists already; choose another name with -o.")
    if not output.parent.is_dir():
        raise BadInputError(f"{output.parent}: there is no such folder.")
    if agree is not None:
        agree(read.tables)
    with written_beside(output) as beside:
        files = [path.name for path in tables.values()]
        setup = _setup(text, stated, sums, read.tables)
        beside.write_bytes(_session(setup, files, measurements))
    return measurements


def _session(setup: SessionSetup, names: list[str], measurements: Measurements) -> bytes:
    """Return the file's content, made in memory: the library ends badly with a full disk."""
    with h5py.File("made", "w", libver=layout.LIBVER, driver="core", backing_store=False) as file:
        fill_file(file, setup)
        _complete(file, names)
        Recorder(file).write_checksums()
        write_derived(file, measurements)
        file.flush()
        image: bytes = file.id.get_file_image()
    return image


def export_session(path: Path, folder: Path) -> list[Path]:
    """Write the measurements of a session as CSV files, about.toml, the devices and the notes.

    Returns the paths. Raises BadInputError when the session was not analysed yet, or not since runs
    or readings were marked, or when a file is there already.
    """
    measurements = load_measurements(Path(path))
    with open_session(path) as session:
        if session.outdated:
            raise BadInputError(f"{path}: {session.outdated}")
        check_free(session, Path(folder))
        check_no_control(Path(folder))
        with all_or_none(Path(folder) / name for name in (*TABLES, CONTROL, *file_names(session))):
            tables = write_tables(measurements, Path(folder))
            control = write_control(session, Path(folder))
            return [*tables, *control, *write_about_and_notes(session, Path(folder))]


def about_text(about: Path | None, forces: Path) -> str:
    """Return the text of about.toml, by default that beside the tables; empty where none is."""
    beside = forces.parent / ABOUT
    path = beside if about is None and beside.exists() else about
    if path is None:
        return ""
    text = read_text(path, file_kinds.ABOUT)
    parse_about(text, str(path))
    return text


def _setup(
    sheet_text: str, about_text: str, sums: dict[str, str], tables: Sequence[TextTable]
) -> SessionSetup:
    understood = {one.path.name: in_one_line(one) for one in tables if not one.as_ours}
    return SessionSetup(
        schedule=Schedule(IMPORTED, (), IMPORTED_FRAME_RATE_HZ),
        texts={"sheet.toml": sheet_text} | ({ABOUT: about_text} if about_text else {}),
        resolved={"imported_sha256": sums} | ({"imported_as": understood} if understood else {}),
        signals=(),
        rate_hz=0.0,
        frame_shape=None,
    )


def _complete(file: h5py.File, names: list[str]) -> None:
    entry = file[layout.ENTRY]
    now = dt.datetime.now(dt.UTC).isoformat(timespec="seconds")
    for name, value in {
        "outcome": Outcome.COMPLETED.value,
        "reason": f"Imported from {', '.join(names)}.",
        "start_time": now,
        "end_time": now,
    }.items():
        entry[name][()] = np.bytes_(value.encode("utf-8"))


def _checksum(path: Path) -> str:
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
