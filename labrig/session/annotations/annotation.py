"""One annotation: what was written, photographed or marked, by whom and when.

Annotations are no part of the recording. They are only ever appended, each with a checksum over
itself and the one before, so that a change or a removal shows; the recording's own checksums stay
as they were.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import unicodedata
import uuid
from dataclasses import dataclass, field, fields
from typing import Any, Final

from labrig.errors import BadInputError

NOTE: Final = "note"
PHOTOGRAPH: Final = "photograph"
MARK: Final = "mark"  # a reading or a run that is declared invalid
KINDS: Final = (NOTE, PHOTOGRAPH, MARK)
TEXT_CHARACTERS_MAX: Final = 10_000
NAME_CHARACTERS_MAX: Final = 120
CONTENT_BYTES_MAX: Final = 16 << 20


def now() -> str:
    """Return the time of day, ISO 8601, UTC."""
    return dt.datetime.now(dt.UTC).isoformat(timespec="seconds")


def new_identifier() -> str:
    """Return an identifier that no other annotation has."""
    return str(uuid.uuid4())


@dataclass(frozen=True, kw_only=True)
class Annotation:
    """What was added to a session. Raises BadInputError when it is too long, or no annotation."""

    kind: str  # one of KINDS
    who: str
    text: str  # the note, the caption, or why
    when: str = field(default_factory=now)
    run: int = -1  # index of the run it concerns; -1: none
    reading: int = -1  # index of the reading it concerns; -1: none, or all of the run
    media_type: str = "text/plain"  # or that of the content: image/jpeg, image/png
    file_name: str = ""
    content: bytes = b""
    identifier: str = field(default_factory=new_identifier)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise BadInputError(f"{self.kind[:40]!r} is no kind of annotation.")
        if self.kind != PHOTOGRAPH and not self.text.strip():
            raise BadInputError(f"A {self.kind} needs a text.")
        _check_text(self.kind, self.text, TEXT_CHARACTERS_MAX)
        for name in (self.who, self.when, self.media_type, self.file_name, self.identifier):
            _check_text(f"name in a {self.kind}", name, NAME_CHARACTERS_MAX)
        if len(self.content) > CONTENT_BYTES_MAX:
            raise BadInputError(
                f"A photograph of {len(self.content) / 1e6:.1f} MB is too large; at most "
                f"{CONTENT_BYTES_MAX / 1e6:.1f} MB are possible."
            )

    @property
    def head(self) -> dict[str, Any]:
        """Everything but the content, as plain JSON."""
        return {name: getattr(self, name) for name in _TYPES}

    def checksum(self, previous: str) -> str:
        """Return the sha256 (hex) over this annotation and the checksum of the one before."""
        head = json.dumps(self.head, sort_keys=True, ensure_ascii=False)
        total = hashlib.sha256(f"{previous}\n{head}\n".encode())
        total.update(self.content)
        return total.hexdigest()


def from_head(head: dict[str, Any], content: bytes) -> Annotation:
    """Return the annotation of a head and a content. Raises ValueError, BadInputError."""
    if head.keys() != _TYPES.keys() or any(
        type(head[name]) is not kind for name, kind in _TYPES.items()
    ):
        raise ValueError("this is no annotation")
    return Annotation(**head, content=content)


_TYPES: Final = {
    each.name: int if each.name in {"run", "reading"} else str
    for each in fields(Annotation)
    if each.name != "content"
}


def _check_text(what: str, text: str, characters_max: int) -> None:
    """Raise BadInputError for a text that is too long, or that a file cannot hold as it is."""
    if len(text) > characters_max:
        raise BadInputError(
            f"A {what} of {len(text)} characters is too long; at most {characters_max} are "
            "possible."
        )
    if any(unicodedata.category(sign) in {"Cc", "Cs"} and sign not in "\n\t" for sign in text):
        raise BadInputError(f"A {what} holds a control character; only line breaks are possible.")
