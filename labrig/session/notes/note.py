"""One note: a text, a photograph, or both, by whom and when.

Notes are no part of the recording. They are only ever appended, in a supplement of the session with
a checksum of its own; the recording's checksums stay as they are.
"""

from __future__ import annotations

import datetime as dt
import unicodedata
import uuid
from dataclasses import dataclass, field, fields
from typing import Any, Final

from labrig.errors import BadInputError
from model.measurements.known_arguments import known_arguments

TEXT_CHARACTERS_MAX: Final = 10_000
NAME_CHARACTERS_MAX: Final = 120
PHOTOGRAPH_BYTES_MAX: Final = 16 << 20


def now() -> str:
    """Return the time of day, ISO 8601, UTC."""
    return dt.datetime.now(dt.UTC).isoformat(timespec="seconds")


def new_identifier() -> str:
    """Return an identifier that no other note has."""
    return str(uuid.uuid4())


@known_arguments
@dataclass(frozen=True, kw_only=True)
class Note:
    """What was added to a session. Raises BadInputError for what a file cannot hold."""

    who: str
    text: str  # the note, or the photograph's caption
    when: str = field(default_factory=now)
    media_type: str = "text/plain"  # of a photograph: image/jpeg or image/png
    file_name: str = ""  # of a photograph
    photograph: bytes = b""  # left out where notes are listed
    identifier: str = field(default_factory=new_identifier)

    def __post_init__(self) -> None:
        if not self.has_photograph and not self.text.strip():
            raise BadInputError("A note needs a text or a photograph.")
        _check_text("note", self.text, TEXT_CHARACTERS_MAX)
        for name in (self.who, self.when, self.media_type, self.file_name, self.identifier):
            _check_text("name in a note", name, NAME_CHARACTERS_MAX)
        if len(self.photograph) > PHOTOGRAPH_BYTES_MAX:
            raise BadInputError(
                f"A photograph of {len(self.photograph) / 1e6:.1f} MB is too large; at most "
                f"{PHOTOGRAPH_BYTES_MAX / 1e6:.1f} MB are possible."
            )

    @property
    def has_photograph(self) -> bool:
        """Whether there is a photograph, also where it was left out."""
        return self.media_type != "text/plain"

    @property
    def head(self) -> dict[str, Any]:
        """Everything but the photograph, as plain JSON."""
        return {name: getattr(self, name) for name in _HEAD}


_HEAD: Final = tuple(each.name for each in fields(Note) if each.name != "photograph")


def from_head(head: dict[str, Any], photograph: bytes) -> Note:
    """Return the note of a head and a photograph. Raises ValueError, BadInputError."""
    if head.keys() != set(_HEAD) or not all(isinstance(value, str) for value in head.values()):
        raise ValueError("this is no note")
    return Note(**head, photograph=photograph)


def _check_text(what: str, text: str, characters_max: int) -> None:
    """Raise BadInputError for a text that is too long, or that a file cannot hold as it is."""
    if len(text) > characters_max:
        raise BadInputError(
            f"A {what} of {len(text)} characters is too long; at most {characters_max} are "
            "possible."
        )
    if any(unicodedata.category(sign) in {"Cc", "Cs"} and sign not in "\n\t" for sign in text):
        raise BadInputError(f"A {what} holds a control character; only line breaks are possible.")
