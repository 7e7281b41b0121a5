"""Ask a running session to pause, by a file beside the session."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from labrig.files import not_written

_MOST_BYTES = 200


class PauseFile:
    """`SESSION.pause` holds who wants the pause; the session continues when it is removed."""

    def __init__(self, session: Path) -> None:
        self.path = session.with_name(f"{session.name}.pause")

    def ask(self, who: str) -> None:
        """Ask for a pause after the present run. Raises LabrigError."""
        try:
            self.path.write_text(who or "somebody", encoding="utf-8")
        except OSError as error:
            raise not_written(self.path, error) from None

    def end(self) -> None:
        """Let the session continue; nothing happens where it does. Raises LabrigError."""
        try:
            self.path.unlink(missing_ok=True)
        except OSError as error:
            raise not_written(self.path, error) from None

    def forget(self) -> None:
        """Remove what an earlier session of this name has left, if that can be done."""
        with suppress(OSError):
            self.path.unlink(missing_ok=True)

    def asked_by(self) -> str:
        """See `protocols.execution.stop.PauseRequest`."""
        try:
            with self.path.open("rb") as file:
                return " ".join(file.read(_MOST_BYTES).decode("utf-8", "replace").split()) or "-"
        except OSError:
            return ""
