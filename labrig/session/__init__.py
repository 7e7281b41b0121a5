"""The session file: write, read, verify, recover, import, export."""

from labrig.session.run_record import RunRecord
from labrig.session.session import LoggedEvent, Session, open_session
from labrig.session.writer import SessionWriter, WriterError

__all__ = ["LoggedEvent", "RunRecord", "Session", "SessionWriter", "WriterError", "open_session"]
