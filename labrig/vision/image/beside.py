"""Find the optics.json and sheet.toml of an image: its own, the stated ones, or its folder's."""

from __future__ import annotations

from pathlib import Path

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
    for candidate in (own_file(path, kind), given, path.with_name(kind)):
        if candidate is not None and (candidate.exists() or candidate is given):
            return candidate
    return None


def own_file(path: Path, kind: str) -> Path:
    """Return where a file of this image alone would be: NAME.optics.json beside NAME.png."""
    return path.with_name(f"{path.stem}.{kind}")


def missing(path: Path, kind: str) -> str:
    """Return the sentence for an image without such a file."""
    own = own_file(path, kind).name
    return f"{path}: there is neither {own} nor {kind} beside it; {_INSTEAD[kind]}."
