"""The session file: write, read, verify, recover, import, export."""

from labrig.session.compare import compare_sessions
from labrig.session.derived import (
    drop_measurements,
    load_finding,
    load_measurements,
    store_finding,
    store_measurements,
    stored_curve_extractor,
)
from labrig.session.exchange import export_session, import_session
from labrig.session.recover import RecoverReport, recover
from labrig.session.run_record import RunRecord
from labrig.session.session import LoggedEvent, RecordedSession, open_session
from labrig.session.tables import read_tables, write_tables
from labrig.session.verify import verify
from labrig.session.writer import SessionWriter, WriterError

__all__ = [
    "LoggedEvent",
    "RecordedSession",
    "RecoverReport",
    "RunRecord",
    "SessionWriter",
    "WriterError",
    "compare_sessions",
    "drop_measurements",
    "export_session",
    "import_session",
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
