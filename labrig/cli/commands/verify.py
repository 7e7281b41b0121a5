"""A session file's structure, checksums and completeness."""

from __future__ import annotations

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json, Recorded
from labrig.cli.screen import print_json, print_table
from labrig.errors import BadInputError


def verify(session: Recorded, as_json: Json = False) -> None:
    """Check a session's structure, checksums and completeness.

    Ends with code 2 on a fault.
    """
    from labrig.session import verify as verify_session

    checks = verify_session(session)
    good = all(check.ok for check in checks)
    if as_json:
        print_json({"ok": good, "checks": [check.as_dict() for check in checks]})
    else:
        rows = [[c.word, c.name, c.found, c.wanted] for c in checks]
        print_table(f"{session}", ["", "check", "found", "wanted"], rows)
    if not good:
        failed = [item for item in checks if not item.ok]
        if failed[0].name == "opens":  # what is wrong names the file
            raise BadInputError(f"{failed[0].found.rstrip('.')}.")
        raise BadInputError(f"{session}: not in order: {', '.join(c.name for c in failed)}.")


COMMAND = Command(
    "verify",
    verify,
    order=100,
    examples=(CommandExample(line="labrig verify session.h5"),),
)
