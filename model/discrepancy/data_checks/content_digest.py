"""A digest of the content of objects, equal for equal content."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np

_PLAIN = frozenset({float, int, bool, str, type(None)})


def content_digest(*values: Any) -> bytes:
    """Return a digest of numbers, texts, arrays, and of dataclasses and collections of them.

    Of another object it has the type and the attributes, or its `repr` where it has none; of a
    function or class the full name.
    """
    pieces = list[bytes]()
    _add(values, pieces)
    lengths = np.array([len(piece) for piece in pieces], dtype="<u8").tobytes()
    digest = hashlib.sha256(lengths)
    digest.update(b"".join(pieces))
    return digest.digest()


def _add(value: Any, to: list[bytes]) -> None:
    """Add the pieces of a value; the kinds that are frequent come first."""
    kind = type(value)
    if kind in _PLAIN:
        to.append(f"{kind.__name__} {value!r}".encode())
    elif isinstance(value, np.ndarray):
        to.append(f"array {value.dtype.str} {value.shape}".encode())
        if value.dtype.hasobject:
            _add(value.tolist(), to)
        else:
            to.append(value.tobytes())
    elif isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        to.append(f"{kind.__name__} {value!r}".encode())
    elif isinstance(value, type) or hasattr(value, "__qualname__"):
        to.append(f"name {value.__module__}.{value.__qualname__}".encode())
    elif isinstance(value, Mapping):
        to.append(f"mapping {len(value)}".encode())
        _add([part for item in value.items() for part in item], to)
    elif isinstance(value, AbstractSet):
        to.append(f"set {len(value)}".encode())
        to.extend(sorted(content_digest(part) for part in value))
    elif isinstance(value, Sequence):
        to.append(f"sequence {len(value)}".encode())
        for part in value:
            _add(part, to)
    else:
        to.append(f"object {kind.__module__}.{kind.__qualname__}".encode())
        _add(_attributes(value), to)


def _attributes(value: Any) -> dict[str, Any] | str:
    """Return what an object holds; of a dataclass its fields, without what it keeps besides."""
    if is_dataclass(value):
        return {name: getattr(value, name) for name in _names(value.__class__)}
    return dict(vars(value)) if hasattr(value, "__dict__") else repr(value)


@cache
def _names(kind: Any) -> tuple[str, ...]:
    """Return the names of a dataclass's fields."""
    return tuple(one.name for one in fields(kind))
