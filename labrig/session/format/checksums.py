"""What a session's checksums cover: content and, since version 3, types, shapes and attributes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

from labrig.session.format import layout
from labrig.session.format.layout import Array

ATTRIBUTES_SINCE = 3  # version of the layout
SUPPLEMENT_SUM = "sha256"  # attribute of a supplement
_BLOCK_BYTES = 1 << 24


def version_of(file: Any) -> int:
    """Return the version of the layout of an open session."""
    return int(file.attrs["labrig_format"])


def covered(file: Any) -> dict[str, Any]:
    """Return the groups and datasets that the table of checksums lists, by full name."""
    found: dict[str, Any] = {"/": file["/"]} if version_of(file) >= ATTRIBUTES_SINCE else {}

    def note(path: str, item: Any) -> None:
        name = f"/{path}"
        if name == layout.CHECKSUMS or layout.in_supplement(name) or layout.in_additional(name):
            return
        if isinstance(item, h5py.Dataset) or version_of(file) >= ATTRIBUTES_SINCE:
            found[name] = item

    file.visititems(note)
    return found


def digest(item: Any, version: int) -> str:
    """Return the sha256 (hex) of a group or dataset, as the table of checksums holds it.

    Raises OSError or RuntimeError for damaged content and ValueError for an attribute of a type
    that a session never holds.
    """
    total = hashlib.sha256()
    if isinstance(item, h5py.Dataset):
        for block in blocks(item):
            total.update(np.ascontiguousarray(block).tobytes())
    return finished(item, version, total)


def finished(item: Any, version: int, content: Any = None) -> str:
    """Return the sha256 (hex) of an object whose content is in the hash `content` already."""
    total = hashlib.sha256() if content is None else content.copy()
    if version >= ATTRIBUTES_SINCE:
        if isinstance(item, h5py.Dataset):  # one without rows has no content to tell it by
            total.update(f"\n{_type_of(item.dtype)} {item.shape}\n".encode())
        for name in sorted(item.attrs):
            total.update(_attribute(item, name))
    return str(total.hexdigest())


def _type_of(dtype: Any) -> str:
    """Return a type in words that do not depend on the version of NumPy."""
    if dtype.names is None:
        return str(dtype.str)
    fields = (dtype[name] for name in dtype.names)
    return ", ".join(
        f"{name} {one.base.str} {one.shape}" for name, one in zip(dtype.names, fields, strict=True)
    )


def supplement_digest(group: Any, version: int) -> str:
    """Return the sha256 (hex) of everything in a supplement but its checksum."""
    if version < ATTRIBUTES_SINCE and group.name == layout.DERIVED:
        return _content_digest(group)
    total = hashlib.sha256()
    for name in sorted(name for name in group.attrs if name != SUPPLEMENT_SUM):
        total.update(_attribute(group, name))
    items: dict[str, Any] = {}
    group.visititems(items.__setitem__)
    for name in sorted(items):
        total.update(f"{name} {digest(items[name], version)}\n".encode())
    return total.hexdigest()


def blocks(dataset: Any) -> Iterator[Array]:
    """Yield a dataset's content in the order of its rows, a few megabytes at a time."""
    if dataset.shape == ():
        yield np.asarray(dataset[()], dtype=dataset.dtype)
        return
    row_bytes = dataset.dtype.itemsize * int(np.prod(dataset.shape[1:], dtype=np.int64))
    step = max(1, _BLOCK_BYTES // max(row_bytes, 1))
    for at in range(0, dataset.shape[0], step):
        yield dataset[at : at + step]


def _content_digest(group: Any) -> str:
    """Return the checksum of derived measurements before version 3: of the datasets' content."""
    total = hashlib.sha256()
    for name in sorted(group):
        total.update(f"{name} {digest(group[name], 2)}\n".encode())
    return total.hexdigest()


def _attribute(item: Any, name: str) -> bytes:
    """Return name, type, shape and value of an attribute."""
    stored = item.attrs.get_id(name)
    if (
        stored.shape is not None
        and h5py.check_string_dtype(stored.dtype)
        and stored.dtype.hasobject
    ):
        texts = [str(text).encode() for text in np.atleast_1d(item.attrs[name])]
        lengths = [len(text) for text in texts]
        return f"\n@{name} text {stored.shape} {lengths}\n".encode() + b"".join(texts)
    if stored.dtype.hasobject or stored.shape is None:
        raise ValueError(f"the attribute {name} of {item.name} has a type that no session holds")
    value = np.zeros(stored.shape, dtype=stored.dtype)
    stored.read(value)
    return f"\n@{name} {stored.dtype.str} {stored.shape}\n".encode() + value.tobytes()
