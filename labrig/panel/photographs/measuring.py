"""Measure one file of a folder of photographs."""

from __future__ import annotations

from pathlib import Path

from labrig.errors import BadInputError, LabrigError
from labrig.panel.photographs.photograph import Found
from labrig.vision.image.reading import Pixels, pictures_in

FileState = tuple[int, int] | None  # time of the last change, ns, and size; None: not there


def file_state(path: Path) -> FileState:
    """Return what changes when a file is replaced or removed."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


class Measured:
    """What came of one file."""

    def __init__(self) -> None:
        self.images: dict[int | None, Pixels] = {}  # by the page of a TIFF, as in `PictureLabel`
        self.curves: dict[int | None, Found] = {}
        self.why = ""


def measured_file(path: Path) -> Measured:
    """Measure all pictures of a file; what is at fault is told in the sentence."""
    from labrig.vision.batch.curves import curves_of  # slow to import: numba
    from labrig.vision.batch.options import BatchOptions

    out = Measured()
    try:
        for label, image, curve in curves_of([path], BatchOptions()):
            if image is not None:
                out.images[label.frame] = image
                out.curves.setdefault(label.frame, []).append((label.strip, curve))
            else:
                out.why = curve.why
    except LabrigError as error:
        out.why = str(error)
    except Exception as error:  # noqa: BLE001 - one photograph must not end the measuring
        out.why = f"measuring failed with {type(error).__name__}: {error}."
    if not out.images:
        try:
            for picture in pictures_in(path):
                if picture.image is not None:
                    out.images[picture.label.frame] = picture.image
        except BadInputError as error:
            out.why = str(error)
    return out
