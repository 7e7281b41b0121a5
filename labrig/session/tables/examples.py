"""Small tables to look at, and to try an import with."""

from __future__ import annotations

from pathlib import Path

from labrig.config.templates import template_text
from labrig.errors import BadInputError
from labrig.files import make_folder, write_bytes

_FOLDER = Path(__file__).parent / "example_files"
SHEET, FORCES, CURVES, LABVIEW = "sheet.toml", "forces.csv", "curves.csv", "labview.txt"


def write_examples(folder: Path) -> list[Path]:
    """Write tables as labrig writes them, and one as LabVIEW does: UTF-16, tabs, decimal commas.

    Raises BadInputError where one of them is there.
    """
    texts = {name: (_FOLDER / name).read_text(encoding="utf-8") for name in (FORCES, CURVES)}
    made = {name: text.encode("utf-8") for name, text in texts.items()}
    made[SHEET] = template_text(SHEET).encode("utf-8")
    made[LABVIEW] = (
        (_FOLDER / LABVIEW).read_text(encoding="utf-8").replace("\n", "\r\n").encode("utf-16")
    )
    for name in made:
        if (folder / name).exists():
            raise BadInputError(f"{folder / name}: is already there; give another folder.")
    make_folder(folder)
    for name, content in made.items():
        write_bytes(folder / name, content)
    return [folder / name for name in sorted(made)]
