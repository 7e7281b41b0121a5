"""Find which proposed measurements were made, to compare promise and result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomlkit

from labrig.config import parse_protocol
from labrig.errors import BadInputError
from labrig.session import open_session
from model.discrepancy import Diagnosis, Next


def promised(earlier: Diagnosis | None, sessions: Sequence[Path]) -> tuple[Next, ...]:
    """Return the proposals of an earlier diagnosis whose protocols further `sessions` have run.

    `earlier` is kept in the first of `sessions`; it holds the proposals before its own, too.
    """
    if earlier is None or len(sessions) < 2:
        return ()
    proposals = [one.proposal for one in earlier.promises]
    if earlier.next_measurement is not None:
        proposals.append(earlier.next_measurement)
    run = [_recorded(path) for path in sessions[1:]]
    made = []
    for one in proposals:
        wanted = _content(tomlkit.dumps(dict(one.protocol))) if one.between else None
        if wanted is not None and wanted in run:
            run.remove(wanted)  # a session keeps one promise
            made.append(one)
    return tuple(made)


def _recorded(path: Path) -> dict[str, Any] | None:
    with open_session(path) as session:
        text = session.texts.get("protocol.toml")
    return None if text is None else _content(text)


def _content(text: str) -> dict[str, Any] | None:
    """Return what a protocol says, with its defaults; None: it is none."""
    try:
        return parse_protocol(text, "protocol.toml").model_dump(mode="json")
    except BadInputError:
        return None
