"""Pixels as cameras send them, made grey: mono of 8 to 16 bit, plain or packed, and Bayer patterns.

Names are GenICam's (PFNC). More than 8 bit become 16 bit with the brightest level at the top, so
that a threshold means the same for every format.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from drivers.interfaces import DeviceError, GreyImage

Bytes = npt.NDArray[np.uint8]
_NAME = re.compile(r"^(Mono|Bayer(?:RG|GR|GB|BG))(8|10|12|14|16)(p|Packed)?$")
# OpenCV names a pattern by the second pixel of the second row on, GenICam by the first ones.
_OPENCV_BAYER = {"RG": "BG", "GR": "GB", "GB": "GR", "BG": "RG"}


@dataclass(frozen=True)
class PixelFormat:
    """A format that can be made grey."""

    name: str
    bits: int
    packing: str  # "": a byte or two each; p: bit after bit; Packed: GigE Vision's two in three
    bayer: str  # RG, GR, GB or BG; empty: mono

    @property
    def dtype(self) -> np.dtype[np.uint8] | np.dtype[np.uint16]:
        """Type of the grey pixels."""
        return np.dtype(np.uint8) if self.bits == 8 else np.dtype(np.uint16)

    def size(self, pixels: int) -> int:
        """Return the bytes of so many pixels."""
        if self.packing == "Packed":
            return pixels * 3 // 2
        return (pixels * self.bits + 7) // 8 if self.packing else pixels * self.dtype.itemsize

    def grey(self, raw: Bytes, rows: int, columns: int) -> GreyImage:
        """Return an image (rows, columns) of its own from a buffer's bytes. Raises DeviceError."""
        needed = self.size(rows * columns)
        if raw.size < needed:
            raise DeviceError(
                f"a frame of {columns} x {rows} {self.name} has {raw.size} bytes; {needed} belong "
                "to it"
            )
        levels = self._levels(raw[:needed], rows * columns).reshape(rows, columns)
        if not self.bayer:
            return levels
        import cv2

        code = getattr(cv2, f"COLOR_Bayer{_OPENCV_BAYER[self.bayer]}2GRAY")
        return np.asarray(cv2.cvtColor(levels, code))

    def _levels(self, raw: Bytes, pixels: int) -> GreyImage:
        if self.bits == 8:
            return raw.copy()
        levels = self._unpacked(raw, pixels)
        return np.asarray(levels << np.uint16(16 - self.bits))

    def _unpacked(self, raw: Bytes, pixels: int) -> npt.NDArray[np.uint16]:
        if not self.packing:
            return raw.view("<u2").astype(np.uint16)
        if self.packing == "Packed":
            low_bits = self.bits - 8
            first, shared, second = (raw[k::3].astype(np.uint16) for k in range(3))
            mask = np.uint16((1 << low_bits) - 1)
            pair = (first << low_bits | shared & mask, second << low_bits | shared >> 4 & mask)
            return np.stack(pair, axis=1).ravel()[:pixels]
        bits = np.unpackbits(raw, bitorder="little")[: pixels * self.bits]
        weights = (1 << np.arange(self.bits)).astype(np.uint16)
        return np.asarray((bits.reshape(pixels, self.bits) * weights).sum(axis=1), np.uint16)


def pixel_format(name: str) -> PixelFormat | None:
    """Return the format of a name; None for one that cannot be made grey."""
    found = _NAME.match(name)
    if found is None:
        return None
    kind, bits, packing = found.group(1), int(found.group(2)), found.group(3) or ""
    possible = {"": (8, 10, 12, 14, 16), "p": (10, 12, 14), "Packed": (10, 12)}
    if bits not in possible[packing]:
        return None
    return PixelFormat(name, bits, packing, kind.removeprefix("Bayer").removeprefix("Mono"))


def check_pixel_format(name: str) -> None:
    """Raise ValueError unless images of this format can be made grey."""
    if pixel_format(name) is None:
        raise ValueError("must be a format such as Mono8, Mono12, Mono12p, Mono16 or BayerRG8")
