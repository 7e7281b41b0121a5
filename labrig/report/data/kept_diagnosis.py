"""A diagnosis kept in its session, with everything that its page is drawn from."""

from __future__ import annotations

from pathlib import Path

from labrig.config.base import parse_json
from labrig.errors import BadInputError
from labrig.files import typed
from labrig.serialise import from_plain, to_json
from labrig.session import load_finding, store_finding
from model.discrepancy.verdict.result import Diagnosis

NAME = "diagnosis"


def keep_diagnosis(session: Path, found: Diagnosis) -> None:
    """Store it in the session, in place of an older one; a new analysis removes it."""
    store_finding(session, NAME, to_json(found))


def kept_diagnosis(session: Path) -> Diagnosis | None:
    """Return the diagnosis that a session holds."""
    text = load_finding(session, NAME)
    if text is None:
        return None
    try:
        plain = parse_json(text, f"{session}: its diagnosis")
        return from_plain(Diagnosis, plain, lenient=True)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BadInputError(
            f"{session}: its diagnosis cannot be read ({error!r}); run "
            f"labrig diagnose {typed(session)} again."
        ) from None
