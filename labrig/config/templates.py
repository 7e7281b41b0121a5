"""The commented files that `labrig init` starts a rig with."""

from __future__ import annotations

import datetime as dt
import re
from pathlib import Path

from drivers.boards import BOARD_FAMILIES, DEFAULT, Starter
from drivers.cameras import CAMERAS
from drivers.cameras.contract import FALLBACK as CAMERA_DEFAULT
from drivers.plugins import UnknownPartError
from labrig.errors import BadInputError
from labrig.files import not_written, write_text

_COMMON = {
    "sheet.toml": "sheet.toml",
    "protocol.toml": "protocol.toml",
    "load_cell.toml": "load_cell.toml",
    "optics.json": "optics.json",
    "about.toml": "about.toml",
}
_COMMENT_AT = 35  # column of the files
DEFAULT_TRIGGER_LINE = "PCI6703/port0/line1"
# The date of calibrations that nobody has made: the shipped files hold values to start from.
NOT_CALIBRATED = dt.date(1970, 1, 1)


def write_templates(
    folder: Path, *, simulated: bool, board: str = DEFAULT, camera: str = CAMERA_DEFAULT
) -> list[Path]:
    """Write the files into `folder`, which may hold others; none is ever overwritten.

    The calibrations are those of the simulated rig, and true of it; of another they are not.
    `board` is the family of boards and `camera` the kind of camera that rig.toml is written for.
    """
    starter = _starter(board)
    camera_text = _camera_starter(camera, simulated=simulated)
    if folder.exists() and not folder.is_dir():
        raise BadInputError(f"{folder}: this is a file, a folder is needed.")
    names = _COMMON | {"rig.toml": "rig_simulated.toml" if simulated else "rig.toml"}
    there = [name for name in sorted(names) if (folder / name).exists()]
    if there:
        raise BadInputError(
            f"{folder / there[0]}: is already there; give another folder, or remove the file."
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, template in names.items():
            text = template_text(template)
            if name == "rig.toml" and board != DEFAULT:
                text = _for_boards(text, starter, simulated=simulated)
            if name == "rig.toml" and camera_text:
                line = DEFAULT_TRIGGER_LINE if starter is None else starter.trigger_line
                text = _for_camera(text, camera_text, line)
            write_text(folder / name, _as_of_today(text) if simulated else text)
    except OSError as error:
        raise not_written(folder, error) from None
    return [folder / name for name in sorted(names)]


def _starter(board: str) -> Starter | None:
    """Return what a family of boards brings to start from; the files have that of the default."""
    try:
        starter = BOARD_FAMILIES.get(board).starter
    except UnknownPartError as error:
        raise BadInputError(f"--board {board}: {error}.") from None
    if starter is None and board != DEFAULT:
        raise BadInputError(f"--board {board}: these boards bring no rig.toml to start from.")
    return starter


def _camera_starter(kind: str, *, simulated: bool) -> str:
    """Return the keys of [camera] that a kind brings; empty: those of the file stay."""
    try:
        part = CAMERAS.get(kind)
    except UnknownPartError as error:
        raise BadInputError(f"--camera {kind}: {error}.") from None
    text = part.simulated_starter if simulated else part.starter
    if not text and kind != CAMERA_DEFAULT:
        raise BadInputError(f"--camera {kind}: this kind brings no [camera] to start from.")
    return text


def _for_camera(text: str, keys: str, line: str) -> str:
    """Return rig.toml with the keys of another kind of camera; `line` may trigger it."""
    named = f'# trigger_line = "{line}"'.ljust(_COMMENT_AT)
    keys = re.sub(r"^# trigger_line = .*(?=# )", lambda _: named, keys, flags=re.MULTILINE)
    return re.sub(
        r"^\[camera\]\n(?:.+\n)+", lambda _: f"[camera]\n{keys}", text, flags=re.MULTILINE
    )


def _for_boards(text: str, starter: Starter | None, *, simulated: bool) -> str:
    """Return rig.toml with the table of another family, and its interlock."""
    if starter is None:
        return text
    table = starter.simulated_table if simulated else starter.table
    text = re.sub(rf"^\[{DEFAULT}\]\n(?:.+\n)+", lambda _: table, text, flags=re.MULTILINE)
    return re.sub(
        r"^# \[interlock\].*\n# line.*\n", lambda _: starter.interlock, text, flags=re.MULTILINE
    )


def _as_of_today(text: str) -> str:
    today = dt.datetime.now(dt.UTC).date()
    return re.sub(rf"{NOT_CALIBRATED}( +#.*)?", str(today), text)


def template_text(name: str) -> str:
    """Return the text of one of the shipped files."""
    return template_path(name).read_text(encoding="utf-8")


def template_path(name: str) -> Path:
    """Where one of the shipped files is."""
    return Path(__file__).parent / "template_files" / name
