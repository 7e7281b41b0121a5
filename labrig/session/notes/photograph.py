"""Photographs for notes: which kinds there are, whether one is whole, and small copies."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, Final

import numpy as np

from labrig.errors import BadInputError
from labrig.session.notes.note import NAME_CHARACTERS_MAX, PHOTOGRAPH_BYTES_MAX, Note

PIXELS_MAX: Final = 80_000_000
SUFFIXES: Final = {"image/jpeg": ".jpg", "image/png": ".png"}
_JPEG, _PNG = b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n"
_NOT_FRAMES = frozenset({0xC4, 0xC8, 0xCC})  # among the markers from C0 to CF, which give a size


def photograph_note(content: bytes, *, who: str, text: str = "", file_name: str = "") -> Note:
    """Return a note with a photograph. Raises BadInputError for what is no JPEG or PNG."""
    media_type = media_type_of(content, file_name or "The photograph")
    name = Path(file_name).name[-NAME_CHARACTERS_MAX:]
    return Note(who=who, text=text, media_type=media_type, file_name=name, photograph=content)


def read_photograph_file(path: Path) -> bytes:
    """Return the content of a photograph's file. Raises BadInputError."""
    try:
        if path.is_dir():
            raise BadInputError(f"{path}: this is a folder, a photograph is needed.")
        if not path.is_file():
            raise BadInputError(f"{path}: there is no such file.")
        if path.stat().st_size > PHOTOGRAPH_BYTES_MAX:
            raise BadInputError(
                f"{path}: has {path.stat().st_size / 1e6:.1f} MB; a photograph may have at most "
                f"{PHOTOGRAPH_BYTES_MAX / 1e6:.1f} MB."
            )
        return path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read ({error.strerror}).") from None


def media_type_of(content: bytes, name: str) -> str:
    """Return image/jpeg or image/png, as the content is, whatever the name says."""
    size = _jpeg_size(content) if content.startswith(_JPEG) else _png_size(content)
    if size is None:
        raise BadInputError(f"{name}: is neither a JPEG nor a PNG; save it as one of them.")
    columns, rows = size
    if not 0 < columns * rows <= PIXELS_MAX:
        raise BadInputError(
            f"{name}: has {columns} x {rows} pixels; at most {PIXELS_MAX // 1_000_000} million "
            "are possible."
        )
    if _decoded(content) is None:
        raise BadInputError(f"{name}: is damaged; it cannot be shown.")
    return "image/jpeg" if content.startswith(_JPEG) else "image/png"


def thumbnail(content: bytes, width_px: int) -> bytes:
    """Return a JPEG of at most that width. Raises BadInputError when there is no photograph."""
    import cv2

    image = _decoded(content)
    if image is None:
        raise BadInputError("A photograph is damaged; it cannot be shown.")
    scale = min(1.0, width_px / image.shape[1])
    if scale < 1.0:
        size = (width_px, max(1, round(image.shape[0] * scale)))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    good, packed = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 85])
    if not good:
        raise BadInputError("A photograph cannot be made smaller.")
    return np.asarray(packed).tobytes()


def pixels_of(content: bytes) -> Any:
    """Return the colours (rows, columns, red green blue). Raises BadInputError when damaged."""
    image = _decoded(content)
    if image is None:
        raise BadInputError("A photograph is damaged; it cannot be shown.")
    return image[:, :, ::-1]


def _decoded(content: bytes) -> Any:
    """Return blue, green and red, a quarter as wide where that is enough; None when damaged."""
    import cv2

    size = _jpeg_size(content) if content.startswith(_JPEG) else _png_size(content)
    if size is None or not 0 < size[0] * size[1] <= PIXELS_MAX:
        return None
    how = cv2.IMREAD_REDUCED_COLOR_4 if min(size) > 4000 else cv2.IMREAD_COLOR
    try:
        return cv2.imdecode(np.frombuffer(content, dtype=np.uint8), how)
    except cv2.error:
        return None


def _png_size(content: bytes) -> tuple[int, int] | None:
    if not content.startswith(_PNG) or content[12:16] != b"IHDR" or len(content) < 24:
        return None
    columns, rows = struct.unpack(">II", content[16:24])
    return columns, rows


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    """Return columns and rows from the frame header of a JPEG; None where there is none."""
    at = 2
    while at + 9 <= len(content) and content[at] == 0xFF:
        marker = content[at + 1]
        if 0xC0 <= marker <= 0xCF and marker not in _NOT_FRAMES:
            rows, columns = struct.unpack(">HH", content[at + 5 : at + 9])
            return columns, rows
        at += 1 if marker == 0xFF else 2 + struct.unpack(">H", content[at + 2 : at + 4])[0]
    return None
