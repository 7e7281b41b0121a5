"""Read images: photographs turned upright, the pages of a TIFF, the frames of a video."""

from __future__ import annotations

import io
import re
import struct
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.config.file_kinds import IMAGE, kind_of_file, other_kind
from labrig.errors import BadInputError
from labrig.files import AnyPath, path_of
from labrig.vision.image.films import frames_in
from labrig.vision.image.image import on_white
from labrig.vision.image.library_messages import without_lines_of_libraries
from labrig.vision.image.names import (
    TIFF_SUFFIXES,
    Picture,
    PictureLabel,
    is_video,
    picture_name,
    whole_file,
)
from model.measurements.known_arguments import known_arguments

_HEIC = frozenset(b"ftyp" + brand for brand in (b"heic", b"heix", b"heim", b"mif1", b"msf1"))
_PNG_WITH_ALPHA = (4, 6)  # colour types
_WEBP_WITH_ALPHA = 0x10  # one of its flags
# of libjpeg, which decodes such a file all the same; its other lines are of harmless faults
_LOST_PIXELS = re.compile(
    "premature end of data|bad (Huffman|arithmetic) code|instead of RST"
    "|extraneous bytes before marker 0xd[0-7]"  # restart markers: what is before them was lost
)

Pixels = npt.NDArray[Any]


def labels_in(path: Path) -> list[PictureLabel]:
    """Return what the pictures of an image file are called; none is decoded.

    Raises BadInputError where it cannot be read.
    """
    if path.suffix.lower() not in TIFF_SUFFIXES:
        return [whole_file(path)]
    pages = len(_tiff_directories(_bytes(path)))
    if pages <= 1:
        return [whole_file(path)]
    return [_page_label(path, page) for page in range(1, pages + 1)]


def _page_label(path: Path, page: int) -> PictureLabel:
    name = picture_name(path)
    return PictureLabel(name=f"{name}:{page}", file_stem=f"{name}_page{page:04d}", frame=page)


def pictures_in(path: Path, every: int = 1) -> Iterator[Picture]:
    """Return the pictures of a file; of frames and pages the first of each `every`.

    Raises BadInputError where the file is none of these, or damaged at its beginning.
    """
    if is_video(path):
        yield from frames_in(path, every)
        return
    data = _bytes(path)
    directories = _tiff_directories(data) if path.suffix.lower() in TIFF_SUFFIXES else []
    if len(directories) <= 1:
        yield Picture(label=whole_file(path), image=_decoded(data, path))
        return
    for page in range(1, len(directories) + 1, every):
        label = _page_label(path, page)
        # with its first directory that of the page, a file is read whatever its other pages hold
        place = np.frombuffer(directories[page - 1], dtype=np.uint8)
        begin = len(place)  # 4, or 8 in a large TIFF: there the header names the first directory
        data[begin : 2 * begin] = place
        try:
            yield Picture(label=label, image=_decoded(data, path))
        except BadInputError:
            why = f"{path}: page {page} is damaged or no image."
            yield Picture(label=label, image=None, why=why)


@known_arguments
def read_image(path: AnyPath) -> Pixels:
    """Return an image: 8 or 16 bit or floats, grey or colour, upright as its camera states."""
    path = path_of(path)
    return _decoded(_bytes(path), path)


def _bytes(path: Path) -> npt.NDArray[np.uint8]:
    if not path.exists():
        raise BadInputError(f"{path}: there is no such file.")
    if path.is_dir():
        raise BadInputError(f"{path}: this is a folder, an image is needed.")
    try:
        data = np.fromfile(path, dtype=np.uint8)
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read ({error.strerror}).") from None
    kind = kind_of_file(path)
    if kind not in ("", IMAGE):
        raise other_kind(path, kind, IMAGE)
    return data


def _flags() -> int:
    import cv2

    # IMREAD_UNCHANGED would leave a photograph as the sensor lay, whatever its EXIF states
    return int(cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH)


def _decoded(data: npt.NDArray[np.uint8], path: Path) -> Pixels:
    import cv2

    theirs: list[str] = []
    # what is wrong with a file is said below, in a sentence
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        with without_lines_of_libraries() as theirs:
            image = cv2.imdecode(data, _flags()) if data.size else None
            if image is not None and _may_be_transparent(data):
                whole = np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED))
                image = _on_white(_upright(whole, data), image)
    except cv2.error:  # such as a header that states more pixels than OpenCV takes
        image = None
    if image is None:
        image = _decoded_by_pillow(data)
    if image is None and bytes(data[4:12]) in _HEIC:
        raise BadInputError(
            f"{path}: a photograph in HEIC, which labrig does not read; save it as JPEG or PNG."
        )
    if image is None:
        raise BadInputError(f"{path}: not an image, or damaged.")
    if any(_LOST_PIXELS.search(line) for line in theirs):
        raise BadInputError(
            f"{path}: this JPEG is damaged, and a part of its picture is lost; copy it again."
        )
    return np.asarray(image)


def _may_be_transparent(data: npt.NDArray[np.uint8]) -> bool:
    """Whether a file is a PNG or WebP with an alpha channel, as its header states."""
    begin = bytes(data[:26]).ljust(26, b"\0")
    if begin[:4] == b"\x89PNG":
        return begin[25] in _PNG_WITH_ALPHA
    return begin[8:16] == b"WEBPVP8X" and bool(begin[20] & _WEBP_WITH_ALPHA)


def _upright(whole: Pixels, data: npt.NDArray[np.uint8]) -> Pixels:
    """Return a picture turned as its EXIF states, which OpenCV does not do with an alpha."""
    from PIL import ExifTags, Image

    with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(data.tobytes())) as file:
        orientation = file.getexif().get(ExifTags.Base.Orientation, 1)
    if orientation in (5, 6, 7, 8):
        whole = whole.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        whole = whole[:, ::-1]
    return whole[::-1] if orientation in (3, 4, 7, 8) else whole


def _on_white(whole: Pixels, opaque: Pixels) -> Pixels:
    """Return a picture on white paper, as viewers show it; `opaque`: the same without alpha."""
    top = np.iinfo(whole.dtype).max
    if whole.ndim != 3 or whole.shape[2] != 4 or whole[..., 3].min() == top:
        return opaque
    colours = on_white(whole)
    return colours if opaque.ndim == 3 else colours[..., 0]


def _decoded_by_pillow(data: npt.NDArray[np.uint8]) -> Pixels | None:
    """Return a TIFF of a kind that OpenCV does not read, such as one of 4 bits; else None."""
    from PIL import Image, ImageOps

    try:
        with (
            warnings.catch_warnings(action="ignore"),  # what is wrong is said by the caller
            Image.open(io.BytesIO(data.tobytes()), formats=["TIFF"]) as opened,
        ):
            image = ImageOps.exif_transpose(opened)
            if image.mode.startswith(("I", "F")):  # 16 or 32 bit, or floats
                return np.asarray(image)
            grey = image.mode in ("1", "L", "LA")
            pixels = np.asarray(image.convert("L" if grey else "RGB"))
    except (OSError, ValueError, SyntaxError, MemoryError, Image.DecompressionBombError):
        return None  # Pillow's words for a file that it does not know, or that is damaged
    return pixels if grey else np.ascontiguousarray(pixels[..., ::-1])  # blue first, as OpenCV


def _tiff_directories(data: npt.NDArray[np.uint8]) -> list[bytes]:
    """Return where each page's directory is, as the file itself writes it; none: not a TIFF."""
    held = data.data
    order = {b"II": "<", b"MM": ">"}.get(bytes(held[:2]))
    if order is None:
        return []
    big = bytes(held[2:4]) == struct.pack(order + "H", 43)
    # the number of entries, the size of one, and the place of the next directory
    count, entry_bytes, next_place = ("Q", 20, "Q") if big else ("H", 12, "I")
    count, next_place = order + count, order + next_place
    found: list[bytes] = []
    seen: set[int] = set()
    at = struct.calcsize(next_place)
    try:
        (place,) = struct.unpack_from(next_place, held, at)
        while place and place not in seen:  # the pages of a damaged file may run in a circle
            (entries,) = struct.unpack_from(count, held, place)
            seen.add(place)
            found.append(struct.pack(next_place, place))
            at = place + struct.calcsize(count) + entries * entry_bytes
            (place,) = struct.unpack_from(next_place, held, at)
    except (struct.error, OverflowError):
        pass  # cut short or damaged: the pages up to there
    return found
