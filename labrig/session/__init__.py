"""The session file: write, read, verify, recover, import, export."""

from labrig.session.derived.store import (
    drop_measurements,
    load_finding,
    load_measurements,
    store_finding,
    store_measurements,
    stored_curve_extractor,
)
from labrig.session.marks.add import add_mark
from labrig.session.marks.mark import Mark
from labrig.session.notes.add import add_note, add_waiting
from labrig.session.notes.note import Note
from labrig.session.reading.compare import compare_sessions
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.session import LoggedEvent, RecordedSession, open_session
from labrig.session.recording.writer import SessionWriter, WriterError
from labrig.session.repair.recover import RecoverReport, is_left_by_a_crash, recover
from labrig.session.repair.verify import verify
from labrig.session.tables import ColumnNames, column_names, read_tables, write_tables
from labrig.session.tables.exchange import export_session, import_session

__all__ = [
    "ColumnNames",
    "LoggedEvent",
    "Mark",
    "Note",
    "RecordedSession",
    "RecoverReport",
    "RunRecord",
    "SessionWriter",
    "WriterError",
    "add_mark",
    "add_note",
    "add_waiting",
    "column_names",
    "compare_sessions",
    "drop_measurements",
    "export_session",
    "import_session",
    "is_left_by_a_crash",
    "load_finding",
    "load_measurements",
    "open_session",
    "read_tables",
    "recover",
    "store_finding",
    "store_measurements",
    "stored_curve_extractor",
    "verify",
    "write_tables",
]
