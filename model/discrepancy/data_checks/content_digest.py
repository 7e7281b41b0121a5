"""A digest of the content of objects, equal for equal content."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def content_digest(*values: Any) -> bytes:
    """Return a digest of numbers, texts, arrays, and of dataclasses and collections of them.

    Of another object it has the type and the attributes, or its `repr` where it has none; of a
    function or class the full name.
    """
    digest = hashlib.sha256()
    for piece in _pieces(values):
        digest.update(len(piece).to_bytes(8, "little"))
        digest.update(piece)
    return digest.digest()


def _pieces(value: Any) -> Iterator[bytes]:
    if isinstance(value, np.ndarray):
        yield f"array {value.dtype.str} {value.shape}".encode()
        yield from _pieces(value.tolist()) if value.dtype.hasobject else (value.tobytes(),)
    elif value is None or isinstance(
        value, bool | int | float | complex | str | bytes | np.generic
    ):
        yield f"{type(value).__name__} {value!r}".encode()
    elif isinstance(value, type) or hasattr(value, "__qualname__"):
        yield f"name {value.__module__}.{value.__qualname__}".encode()
    elif isinstance(value, Mapping):
        yield f"mapping {len(value)}".encode()
        yield from _pieces([part for item in value.items() for part in item])
    elif isinstance(value, AbstractSet):
        yield f"set {len(value)}".encode()
        yield from sorted(content_digest(part) for part in value)
    elif isinstance(value, Sequence):
        yield f"sequence {len(value)}".encode()
        for part in value:
            yield from _pieces(part)
    else:
        yield f"object {type(value).__module__}.{type(value).__qualname__}".encode()
        yield from _pieces(_attributes(value))


def _attributes(value: Any) -> dict[str, Any] | str:
    """Return what an object holds; of a dataclass its fields, without what it keeps besides."""
    if is_dataclass(value):
        return {one.name: getattr(value, one.name) for one in fields(value)}
    return dict(vars(value)) if hasattr(value, "__dict__") else repr(value)
