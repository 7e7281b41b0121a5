"""Opens an HDF5 file whose writer was killed, without touching it.

The file's first block says that a writer has it, and how long it was when that was last written.
Both are corrected in memory, which is what the library's h5clear tool does on the disk. Opening it
as a live file would do as well while the file is sound, but waits practically for ever on one that
is not.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

_BLOCK = struct.Struct("<8sBBBBQQQQ")  # signature, version, sizes, flags, addresses
_FLAGS, _END = 4, 7  # places of the consistency flags and of the end of the file among them
_LENGTH = _BLOCK.size + 4  # and its checksum
_MASK = 0xFFFFFFFF


class _Unlocked(io.FileIO):
    """A file, read-only, whose first block is another one."""

    def __init__(self, path: Path, block: bytes) -> None:
        super().__init__(path, "r")
        self._block = block

    def readinto(self, buffer: Any) -> int:
        """See `io.RawIOBase`."""
        view = memoryview(buffer).cast("B")
        at = self.tell()
        count = super().readinto(view) or 0
        if at < len(self._block):
            own = self._block[at : at + count]
            view[: len(own)] = own
        return count


@contextmanager
def unlocked(path: Path) -> Iterator[Any]:
    """Yield the file for reading, as its writer left it. Raises OSError when it is no such file."""
    with path.open("rb") as file:
        block = file.read(_LENGTH)
        size = file.seek(0, io.SEEK_END)
    with _Unlocked(path, _released(block, size)) as raw, h5py.File(raw, "r") as found:
        yield found


def _released(block: bytes, size: int) -> bytes:
    """Return the first block without its flags, and with the file's true length."""
    if len(block) < _LENGTH or block[8] not in (2, 3):
        raise OSError("its first block is damaged")
    fields = list(_BLOCK.unpack_from(block))
    _, _, offsets, lengths, _, base, _, end, _ = fields
    if int.from_bytes(block[_BLOCK.size : _LENGTH], "little") != lookup3(block[: _BLOCK.size]):
        raise OSError("its first block is damaged")
    if base != 0 or (offsets, lengths) != (8, 8):
        raise OSError("its first block is of an unknown kind")
    if size < end:
        raise OSError(f"it is truncated to {size} of {end} bytes")
    fields[_FLAGS], fields[_END] = 0, size
    fixed = _BLOCK.pack(*fields)
    return fixed + lookup3(fixed).to_bytes(4, "little")


def lookup3(data: bytes) -> int:
    """Bob Jenkins' lookup3 hash of some bytes (at least one), the checksum of HDF5's metadata."""
    a = b = c = (0xDEADBEEF + len(data)) & _MASK
    body = (len(data) - 1) // 12 * 12
    for at in range(0, body, 12):
        x, y, z = struct.unpack_from("<III", data, at)
        a, b, c = _mix((a + x) & _MASK, (b + y) & _MASK, (c + z) & _MASK)
    x, y, z = struct.unpack("<III", data[body:].ljust(12, b"\0"))
    return _final((a + x) & _MASK, (b + y) & _MASK, (c + z) & _MASK)


def _turn(value: int, bits: int) -> int:
    return ((value << bits) | (value >> (32 - bits))) & _MASK


def _mix(a: int, b: int, c: int) -> tuple[int, int, int]:
    for bits in (4, 6, 8, 16, 19, 4):
        a = ((a - c) ^ _turn(c, bits)) & _MASK
        c = (c + b) & _MASK
        a, b, c = b, c, a
    return a, b, c


def _final(a: int, b: int, c: int) -> int:
    for bits in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _turn(b, bits)) & _MASK
        a, b, c = b, c, a
    # Seven turns leave the last one computed, c, in the place of b.
    return b
