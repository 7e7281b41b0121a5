"""The commented files that `labrig init` starts a rig with."""

from __future__ import annotations

from pathlib import Path

from labrig.errors import BadInputError

_COMMON = {
    "sheet.toml": "sheet.toml",
    "protocol.toml": "protocol.toml",
    "load_cell.toml": "load_cell.toml",
    "optics.json": "optics.json",
}


def write_templates(folder: Path, *, simulated: bool) -> list[Path]:
    """Write the files into `folder`, which may hold others; none is ever overwritten."""
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
            (folder / name).write_text(template_text(template), encoding="utf-8")
    except OSError as error:
        raise BadInputError(f"{folder}: cannot be written ({error.strerror}).") from None
    return [folder / name for name in sorted(names)]


def template_text(name: str) -> str:
    """The text of one of the shipped files."""
    return template_path(name).read_text(encoding="utf-8")


def template_path(name: str) -> Path:
    """Where one of the shipped files is."""
    return Path(__file__).parent / "template_files" / name
