"""What an analysis process is asked to do: one line of JSON on its standard input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from labrig.errors import BadInputError
from labrig.serialise import from_json, to_json

AnalysisKind = Literal["analyze", "fit", "diagnose", "report", "next", "live"]
KINDS: tuple[AnalysisKind, ...] = get_args(AnalysisKind)


@dataclass(frozen=True, kw_only=True)
class AnalysisOrder:
    """The session is a whole path; `live` follows it while it is recorded."""

    kind: AnalysisKind
    session: str
    workers: int = 1  # processes that search for curves at a time
    between: tuple[str, str] | None = None  # of `next`: two effects; None: those of the diagnosis

    def to_json(self) -> str:
        """One line."""
        return to_json(self) + "\n"

    @classmethod
    def from_json(cls, text: str) -> AnalysisOrder:
        """Return the reverse. Raises BadInputError."""
        try:
            return from_json(cls, text)
        except ValueError as error:
            raise BadInputError(f"an order cannot be read ({error}).") from None
