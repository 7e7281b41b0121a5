"""The session file: write, read, verify, recover, import, export."""

from labrig.session.compare import compare_sessions
from labrig.session.derived import drop_measurements, load_measurements, store_measurements
from labrig.session.recover import RecoverReport, recover
from labrig.session.run_record import RunRecord
from labrig.session.session import LoggedEvent, Session, open_session
from labrig.session.verify import Check, verify
from labrig.session.writer import SessionWriter, WriterError

__all__ = [
    "Check",
    "LoggedEvent",
    "RecoverReport",
    "RunRecord",
    "Session",
    "SessionWriter",
    "WriterError",
    "compare_sessions",
    "drop_measurements",
    "load_measurements",
    "open_session",
    "recover",
    "store_measurements",
    "verify",
]
