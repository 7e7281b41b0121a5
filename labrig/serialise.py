"""JSON of dataclasses: the one place where objects become texts and come back.

`protocols.serialise` does the work, since a schedule must be written without labrig. `finite` is
for output that others read, where a number that JSON does not have is null.
"""

from __future__ import annotations

import json
import math
from typing import Any, TypeVar

from protocols.serialise import SerialiseError, from_plain, to_plain

__all__ = ["SerialiseError", "finite", "from_json", "from_plain", "to_json", "to_plain"]

Made = TypeVar("Made")


def to_json(value: Any) -> str:
    """Return the object as a JSON text that `from_json` reads without loss."""
    return json.dumps(to_plain(value), allow_nan=False)


def from_json(kind: type[Made], text: str | bytes, *, lenient: bool = False) -> Made:
    """Return the object of a class; raises ValueError for a text that is none.

    `lenient` leaves out keys that are not known, which a later version may have written.
    """
    try:
        plain = json.loads(text)
    except RecursionError:
        raise SerialiseError("the text has too many brackets in one another") from None
    return from_plain(kind, plain, lenient=lenient)


def finite(value: Any) -> Any:
    """Return the same structure of plain types, with None for NaN and infinities."""
    if isinstance(value, dict):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if hasattr(value, "tolist"):  # numpy arrays and scalars
        return finite(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
