"""A diagnosis kept in its session, with everything that its page is drawn from."""

from __future__ import annotations

import json
from pathlib import Path

from labrig.config.base import parse_json
from labrig.errors import BadInputError
from labrig.report.parts.plain import from_plain, to_plain
from labrig.session import load_finding, store_finding
from model.discrepancy.verdict.result import Diagnosis

NAME = "diagnosis"


def keep_diagnosis(session: Path, found: Diagnosis) -> None:
    """Store it in the session, in place of an older one; a new analysis removes it."""
    store_finding(session, NAME, json.dumps(to_plain(found), allow_nan=False))


def kept_diagnosis(session: Path) -> Diagnosis | None:
    """Return the diagnosis that a session holds."""
    text = load_finding(session, NAME)
    if text is None:
        return None
    try:
        return from_plain(Diagnosis, parse_json(text, f"{session}: its diagnosis"))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BadInputError(
            f"{session}: its diagnosis cannot be read ({error!r}); run labrig diagnose {session} "
            "again."
        ) from None
