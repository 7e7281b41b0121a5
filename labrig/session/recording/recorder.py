"""Puts rows into an open session file."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any

import h5py
import numpy as np

from labrig.session.format import layout
from labrig.session.format.checksums import digest, finished, version_of
from labrig.session.format.layout import Array
from labrig.session.recording.rows import EventRows

# Rows wait in memory for others of their dataset up to so many bytes: the library takes a tenth of
# a millisecond for each resize and write, however small.
_WAITING_BYTES = 1 << 20


class MisplacedRowsError(ValueError):
    """Rows that do not continue what the dataset holds."""


@dataclass(kw_only=True)
class _Growing:
    """A dataset that grows, and the rows that wait to be added to it."""

    dataset: Any
    row_type: np.dtype[Any]
    row_shape: tuple[int, ...]
    length: int  # with those that wait
    waiting: list[Array] = field(default_factory=list)


class Recorder:
    """Applies rows to a session file that was made by `create_file`.

    Small rows are collected: they are in the file after `put`, `let_go` or `write_checksums`.
    """

    def __init__(self, file: Any) -> None:
        self._file = file
        self._growing: dict[str, _Growing] = {}
        self._digests: dict[str, Any] = {}
        self._waiting_bytes = 0

    def apply(self, rows: EventRows) -> None:
        """Take rows. Raises MisplacedRowsError, KeyError (no such dataset), OSError (the disk)."""
        if rows.at is None:
            dataset = self._file[rows.path]
            if not isinstance(dataset, h5py.Dataset) or dataset.shape not in ((), (1,)):
                raise MisplacedRowsError(f"{rows.path} is no single value")
            dataset[()] = rows.array(dataset.dtype, ())
            return
        growing = self._grown(rows.path)
        dataset = growing.dataset
        if growing.length != rows.at:
            raise MisplacedRowsError(
                f"{rows.path} has {growing.length} rows and is to get row {rows.at}"
            )
        if rows.count == 0:
            return
        values = rows.array(growing.row_type, growing.row_shape)
        if rows.packed and (rows.count != 1 or dataset.chunks != (1, *growing.row_shape)):
            raise MisplacedRowsError(f"{rows.path} takes no packed image")
        if rows.packed:
            # Deflated already, outside of the library and its lock: goes to the disk as it is.
            dataset.resize(rows.at + 1, axis=0)
            dataset.id.write_direct_chunk((rows.at,) + (0,) * (dataset.ndim - 1), rows.blob)
        else:
            growing.waiting.append(values)
            self._waiting_bytes += values.nbytes
        growing.length += rows.count
        self._digests.setdefault(rows.path, hashlib.sha256()).update(values.data)
        if self._waiting_bytes > _WAITING_BYTES:
            self.put()

    def put(self) -> None:
        """Write the rows that wait."""
        for growing in self._growing.values():
            if growing.waiting:
                values = np.concatenate(growing.waiting)
                growing.waiting = []
                growing.dataset.resize(growing.length, axis=0)
                growing.dataset[growing.length - len(values) :] = values
        self._waiting_bytes = 0

    def _grown(self, path: str) -> _Growing:
        found = self._growing.get(path)
        if found is None:
            dataset = self._file[path]
            if not isinstance(dataset, h5py.Dataset) or not dataset.shape or not dataset.chunks:
                raise MisplacedRowsError(f"{path} takes no rows")
            length, *row_shape = dataset.shape
            found = _Growing(
                dataset=dataset, row_type=dataset.dtype, row_shape=tuple(row_shape), length=length
            )
            self._growing[path] = found
        return found

    def let_go(self) -> None:
        """Forget the datasets of the run that is over, so that few are open at a time."""
        self.put()
        self._growing.clear()

    def write_checksums(self) -> None:
        """Write the sha256 of each object; appended content is known without reading."""
        self.put()
        table, version = self._file[layout.CHECKSUMS], version_of(self._file)
        rows = table[()]
        for row in rows:
            path = row["dataset"].decode()
            known, item = self._digests.get(path), self._file[path]
            row["sha256"] = (
                finished(item, version, known) if known else digest(item, version)
            ).encode()
        table[()] = rows
