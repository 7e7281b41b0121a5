"""Puts rows into an open session file."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from labrig.session import layout
from labrig.session.layout import Array
from labrig.session.rows import Rows

_BLOCK_BYTES = 1 << 24


class MisplacedRowsError(ValueError):
    """Rows that do not continue what the dataset holds."""


class Recorder:
    """Applies rows to a session file that was made by `create_file`."""

    def __init__(self, file: Any) -> None:
        self._file = file
        self._open: dict[str, Any] = {}
        self._digests: dict[str, Any] = {}

    def apply(self, rows: Rows) -> None:
        """Write rows. Raises MisplacedRowsError, KeyError (no such dataset), OSError (the disk)."""
        dataset = self._dataset(rows.path)
        if rows.at is None:
            dataset[()] = rows.array(dataset.dtype, ())
            return
        if dataset.shape[0] != rows.at:
            raise MisplacedRowsError(
                f"{rows.path} has {dataset.shape[0]} rows and is to get row {rows.at}"
            )
        if rows.count == 0:
            return
        values = rows.array(dataset.dtype, dataset.shape[1:])
        dataset.resize(rows.at + rows.count, axis=0)
        if rows.packed:
            # Deflated already, outside of the library and its lock: goes to the disk as it is.
            dataset.id.write_direct_chunk((rows.at,) + (0,) * (dataset.ndim - 1), rows.blob)
        else:
            dataset[rows.at :] = values
        self._digests.setdefault(rows.path, hashlib.sha256()).update(values.data)

    def _dataset(self, path: str) -> Any:
        found = self._open.get(path)
        if found is None:
            found = self._open[path] = self._file[path]
        return found

    def let_go(self) -> None:
        """Forget the datasets of the run that is over, so that few are open at a time."""
        self._open.clear()

    def write_checksums(self) -> None:
        """The sha256 of every dataset; those appended to here are known without reading them."""
        table = self._file[layout.CHECKSUMS]
        rows = table[()]
        for row in rows:
            path = row["dataset"].decode()
            known = self._digests.get(path)
            row["sha256"] = (known.hexdigest() if known else digest(self._file[path])).encode()
        table[()] = rows


def digest(dataset: Any) -> str:
    """The sha256 of a dataset's content (its bytes in C order), read block by block."""
    found = hashlib.sha256()
    for block in blocks(dataset):
        found.update(np.ascontiguousarray(block).tobytes())
    return found.hexdigest()


def blocks(dataset: Any) -> Iterator[Array]:
    """A dataset's content in the order of its rows, a few megabytes at a time."""
    if dataset.shape == ():
        yield np.asarray(dataset[()], dtype=dataset.dtype)
        return
    row_bytes = dataset.dtype.itemsize * int(np.prod(dataset.shape[1:], dtype=np.int64))
    step = max(1, _BLOCK_BYTES // max(row_bytes, 1))
    for at in range(0, dataset.shape[0], step):
        yield dataset[at : at + step]
