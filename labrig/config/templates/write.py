"""The commented files that `labrig init` starts a rig with."""

from __future__ import annotations

import dataclasses
import datetime as dt
import inspect
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from drivers.boards import BOARD_FAMILIES, DEFAULT, Starter
from drivers.cameras import CAMERAS
from drivers.cameras.contract import FALLBACK as CAMERA_DEFAULT
from drivers.cameras.contract import CameraSettings
from drivers.force_sensors.contract import DEFAULT as FORCE_DEFAULT
from drivers.force_sensors.contract import FORCE_SENSORS
from drivers.plugins import PluginFolder, UnknownPartError
from drivers.positioners.contract import DEFAULT as STAGE_DEFAULT
from drivers.positioners.contract import POSITIONERS
from labrig.config.derived import SIMULATED
from labrig.config.protocol import PROTOCOLS
from labrig.config.templates.settings_text import settings_text
from labrig.errors import BadInputError
from labrig.files import not_written, write_text
from protocols import ProtocolKind

Kind = TypeVar("Kind")
_COMMON = {
    "sheet.toml": "sheet.toml",
    "protocol.toml": "protocol.toml",
    "load_cell.toml": "load_cell.toml",
    "optics.json": "optics.json",
    "about.toml": "about.toml",
}
PROTOCOL_DEFAULT = "pulse_train"  # the kind in the shipped file
_COMMENT_AT = 35  # column of the files
DEFAULT_TRIGGER_LINE = "PCI6703/port0/line1"
# The date of calibrations that nobody has made: the shipped files hold values to start from.
NOT_CALIBRATED = dt.date(1970, 1, 1)


def write_templates(
    folder: Path,
    *,
    simulated: bool,
    board: str = DEFAULT,
    camera: str = CAMERA_DEFAULT,
    stage: str = STAGE_DEFAULT,
    force_sensor: str = FORCE_DEFAULT,
    protocol: str = PROTOCOL_DEFAULT,
) -> list[Path]:
    """Write the files into `folder`, which may hold others; none is ever overwritten.

    The calibrations are those of the simulated rig, and true of it; of another they are not.
    `board`, `camera`, `stage` and `force_sensor` are the kinds that rig.toml is written for,
    `protocol` that of protocol.toml.
    """
    protocol_kind = _part(PROTOCOLS, "--protocol", protocol)
    starter = _starter(board, simulated=simulated)
    camera_text = _camera_starter(camera, simulated=simulated)
    ports = {"port": SIMULATED} if simulated else {}
    tables = {
        "stage": _kind_table(POSITIONERS, "--stage", (stage, STAGE_DEFAULT), ports),
        "force_sensor": _kind_table(
            FORCE_SENSORS, "--force-sensor", (force_sensor, FORCE_DEFAULT), ports
        ),
    }
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
            if name == "rig.toml":
                text = _with_tables(text, tables)
            if name == "protocol.toml" and protocol != PROTOCOL_DEFAULT:
                text = _for_protocol(text, protocol_kind)
            write_text(folder / name, _as_of_today(text) if simulated else text)
    except OSError as error:
        raise not_written(folder, error) from None
    return [folder / name for name in sorted(names)]


def _starter(board: str, *, simulated: bool) -> Starter | None:
    """Return what a family of boards brings to start from; the files have that of the default.

    Of a family that brings nothing, its settings are the text.
    """
    family = _part(BOARD_FAMILIES, "--board", board)
    if family.starter is not None or board == DEFAULT:
        return family.starter
    if simulated and not family.can_be_simulated:
        raise BadInputError(
            f"--board {board}: these boards bring no simulated rig to start from; leave out "
            "--simulated."
        )
    return Starter(
        table=f"[{board}]\n{settings_text(family.settings)}",
        simulated_table=f"[{board}]\n{settings_text(family.settings, {'address': SIMULATED})}",
        interlock="",
    )


def _part(folder: PluginFolder[Kind], option: str, name: str) -> Kind:
    try:
        return folder.get(name)
    except UnknownPartError as error:
        raise BadInputError(f"{option} {name}: {error}.") from None


def _kind_table(
    folder: PluginFolder[Any], option: str, kinds: tuple[str, str], known: Mapping[str, str]
) -> str:
    """Return the keys of a table that names its kind, of the wanted and the default one.

    Empty: the file's own stay.
    """
    kind, default = kinds
    part = _part(folder, option, kind)
    return "" if kind == default else f'kind = "{kind}"\n{settings_text(part.settings, known)}'


def _with_tables(text: str, tables: Mapping[str, str]) -> str:
    """Return rig.toml with other keys in these tables; those that are empty stay as they are."""
    for name, keys in tables.items():
        if keys:
            text = re.sub(rf"^(# )?\[{name}\].*\n(?:.+\n?)*", "", text, flags=re.MULTILINE)
            text = f"{text.rstrip()}\n\n[{name}]\n{keys}"
    return re.sub(r"\n{3,}", "\n\n", text)


def _camera_starter(kind: str, *, simulated: bool) -> str:
    """Return the keys of [camera] that a kind brings; empty: those of the file stay."""
    part = _part(CAMERAS, "--camera", kind)
    text = part.simulated_starter if simulated else part.starter
    if text or kind == CAMERA_DEFAULT:
        return text
    if simulated:
        raise BadInputError(
            f"--camera {kind}: this kind brings no simulated [camera] to start from; leave out "
            "--simulated."
        )
    known = {"source": part.prefix} if part.prefix else {"kind": kind}
    first = "" if part.prefix else f'kind = "{kind}"\n'
    common = {field.name for field in dataclasses.fields(CameraSettings)} - {"source"}
    own = settings_text(part.settings, known, without=common - part.sets)
    return f'{first}{own}optics = "optics.json"\n'


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


def _for_protocol(text: str, kind: type[ProtocolKind]) -> str:
    """Return protocol.toml with the table of another kind of protocol."""
    said = inspect.cleandoc(kind.__doc__ or "").split("\n")[0]
    first = f"# What is done at each position. {said}\n"
    table = f"[{kind.name}]\n{settings_text(kind)}"
    text = re.sub(r"\A(?:#.*\n)+", lambda _: first, text)
    return re.sub(rf"^\[{PROTOCOL_DEFAULT}\]\n(?:.+\n)+", lambda _: table, text, flags=re.MULTILINE)


def _as_of_today(text: str) -> str:
    today = dt.datetime.now(dt.UTC).date()
    return re.sub(rf"{NOT_CALIBRATED}( +#.*)?", str(today), text)


def template_text(name: str) -> str:
    """Return the text of one of the shipped files."""
    return template_path(name).read_text(encoding="utf-8")


def template_path(name: str) -> Path:
    """Where one of the shipped files is."""
    return Path(__file__).parents[1] / "template_files" / name
