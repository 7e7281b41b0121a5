"""The queue as plain data, and its file in the panel's own folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal

from labrig.files import write_text
from labrig.panel.job.registry import hidden_folder
from labrig.serialise import from_json, to_json, to_plain

_NAME = "queue.json"
_MOST_BYTES = 1 << 20


class State(StrEnum):
    """What becomes of an entry."""

    WAITING = "waiting"
    RUNNING = "running"
    COMPLETED = "completed"
    STOPPED = "stopped"  # anything else


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One session: names of files in the rig's folder, the session's in the data folder."""

    id: str
    protocol: str
    sheet: str
    session: str
    clock: Literal["real", "virtual"] = "virtual"  # of a simulated rig
    about: str | None = None  # text, in place of the about.toml beside rig.toml
    estimate_s: float | None = None
    state: State = State.WAITING
    job: str | None = None  # the job that runs it, or has run it
    text: str = ""  # how it ended


@dataclass(frozen=True, kw_only=True)
class Queue:
    """All entries in their order, and whether the next one begins by itself."""

    entries: tuple[Entry, ...] = field(default=())
    going: bool = False
    by: str = ""  # who started it
    text: str = ""  # why it does not go on

    def message(self) -> dict[str, Any]:
        """Return the message for pages."""
        return {"type": "queue", **to_plain(self)}

    def first(self, state: State) -> Entry | None:
        """Return the first entry in a state."""
        return next((entry for entry in self.entries if entry.state is state), None)


def read_queue(data: Path) -> Queue:
    """Return the queue of a data folder; an empty one where there is none that can be read."""
    try:
        with (hidden_folder(data) / _NAME).open("rb") as file:
            return from_json(Queue, file.read(_MOST_BYTES), lenient=True)
    except (OSError, ValueError):
        return Queue()


def write_queue(data: Path, queue: Queue) -> None:
    """Keep it, whole or not at all. Raises LabrigError."""
    write_text(hidden_folder(data) / _NAME, to_json(queue))
