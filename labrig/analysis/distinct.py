"""Whether several sessions are several recordings: a copy is no further measurement."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import BadInputError
from labrig.session.reading.session import open_session

if TYPE_CHECKING:
    from labrig.session.reading.session import RecordedSession


def check_distinct(paths: Sequence[Path]) -> None:
    """Raise BadInputError where two of these sessions hold the same recording.

    Its scatter would count twice, and the uncertainties would come out too small.
    """
    if len(paths) < 2:
        return
    known: dict[str, Path] = {}
    origins: list[tuple[Path, str, str]] = []  # of each that holds another's recording: how, whose
    for path in paths:
        with open_session(path) as session:
            first = known.setdefault(session.identifier, path)
            origins += [(path, how, whose) for how, whose in _origins(session)]
        if first is not path:
            same_file = first.resolve() == path.resolve()
            what = "is given twice" if same_file else f"is a copy of {first}"
            raise BadInputError(f"{path}: {what}; give each session once.")
    for path, how, whose in origins:
        if whose in known:
            raise BadInputError(f"{path}: {how} {known[whose]}; give one of the two.")


def _origins(session: RecordedSession) -> list[tuple[str, str]]:
    """Return how the session holds the recordings of others, and their identifiers."""
    found = [("is a replay of", session.replay_of)] if session.replay_of else []
    return [*found, *(("holds the complete runs of", whose) for whose in session.continues)]
