"""Find the optics.json and sheet.toml of an image: its own, the stated ones, or its folder's."""

from __future__ import annotations

from pathlib import Path

from labrig.vision.image.names import picture_name

OPTICS_FILE = "optics.json"
SHEET_FILE = "sheet.toml"

_INSTEAD = {
    OPTICS_FILE: "name one for all images (--optics), make one from a ruler in the picture "
    "(labrig calibrate camera), or click it on a page (labrig curves --page FOLDER)",
    SHEET_FILE: "name one for all images (--sheet), write one with the line free_length_mm = 50, "
    "or have the length measured (--to-end, or --tip-px)",
}


def beside(path: Path, kind: str, given: Path | None) -> Path | None:
    """Return the file of a kind that an image uses; None where there is none."""
    of_its_name = path.with_name(f"{path.stem}.{kind}")
    for candidate in (own_file(path, kind), of_its_name, given, path.with_name(kind)):
        if candidate is not None and (candidate.exists() or candidate is given):
            return candidate
    return None


def own_file(path: Path, kind: str) -> Path:
    """Return where a file of this image alone is or would be: NAME.optics.json beside NAME.png.

    With NAME.jpg beside that it is NAME.png.optics.json; NAME.optics.json then serves both.
    """
    whole = path.with_name(f"{path.name}.{kind}")
    return whole if whole.exists() else path.with_name(f"{picture_name(path)}.{kind}")


def missing(path: Path, kind: str) -> str:
    """Return the sentence for an image without such a file."""
    own = own_file(path, kind).name
    return f"{path}: there is neither {own} nor {kind} beside it; {_INSTEAD[kind]}."
