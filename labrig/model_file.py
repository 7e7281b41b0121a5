"""A `SheetModel` as a TOML file: what `labrig fit` and `diagnose` write."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Array, Item, Trivia, Whitespace

from labrig.config.base import parse_toml, read_text
from labrig.config.file_kinds import MODEL, refuse_other_kind
from labrig.errors import BadArgumentError, BadInputError, type_in_words
from labrig.files import AnyPath, check_free, path_of, write_text
from model import ModelError, SheetModel
from model.measurements.known_arguments import known_arguments

_HEADER = (
    "The model of a sheet, written by labrig fit or labrig diagnose; labrig simulate, design,",
    "compare --model and diagnose --model read it. Parameters have their standard uncertainty",
    "(sigma) and unit beside them; s_m is the distance from the clamp.",
)


@known_arguments
def load_model(path: AnyPath) -> SheetModel:
    """Read a model file, as `labrig fit -o` or `save_model` wrote it.

    Raises BadInputError of one sentence that names file and key.
    """
    path = path_of(path)
    text = read_text(path, MODEL)
    refuse_other_kind(text, str(path), MODEL)
    data = parse_toml(text, str(path))
    try:
        return SheetModel.from_dict(data)
    except ModelError as error:
        raise BadInputError(f"{path}: {error}.") from None


def moving_configuration(model: SheetModel, path: Path | str, wanted: str | None) -> str:
    """Return the configuration to follow in time; `wanted` is needed where there are several.

    Raises BadInputError, which names the file.
    """
    known = list(model.dynamic)
    if not known:
        raise BadInputError(
            f"{path}: knows the sheet at rest only; fit it in time with labrig fit --dynamic."
        )
    if wanted is None and len(known) > 1:
        raise BadArgumentError(
            f"{path}: has several configurations; name one with configuration: {', '.join(known)}.",
            "configuration",
        )
    if wanted is not None and wanted not in known:
        raise BadInputError(f"{path}: does not know {wanted} in time; it knows {', '.join(known)}.")
    return wanted or known[0]


@known_arguments
def save_model(model: SheetModel, path: AnyPath, *, force: bool = False) -> None:
    """Write a model file (TOML), which `load_model` and the commands read.

    It is written beside its place and renamed, so that with `force` a file of that name is replaced
    whole. Raises LabrigError of one sentence where a file is there already, unless `force`, where
    it cannot be written, its name does not end with .toml, or it is no model.
    """
    if not isinstance(model, SheetModel):  # a caller may give anything
        raise no_model(model, "a model")
    path = path_of(path)
    check_name(path)
    check_free(path, force=force)
    write_text(path, model_text(model))


def no_model(value: object, wanted: str) -> BadInputError:
    """Return the error to raise for what is no model; it names those that a fit has."""
    of_fit = "; a fit has three: preferred_model, model and varying_model"
    return BadInputError(
        f"{wanted} is needed, not {type_in_words(value)}"
        f"{of_fit if hasattr(value, 'preferred_model') else ''}."
    )


def check_name(path: Path) -> None:
    """Raise BadInputError for a file whose name does not say that it is TOML, as model files are.

    `labrig list` and the page look for them by that.
    """
    if path.suffix.lower() != ".toml" and not path.is_dir():
        raise BadInputError(f"{path}: a model file is TOML; name it {path.stem}.toml.")


def model_text(model: SheetModel) -> str:
    """Return the text of a model file."""
    document = tomlkit.document()
    for line in _HEADER:
        document.add(tomlkit.comment(line))
    for key, value in _plain(model.to_dict()).items():
        document.add(key, value)
    return tomlkit.dumps(document)


def _array(values: Sequence[Any]) -> Array:
    """Return numbers, words or such arrays as an array: appending to one takes the square of it."""
    parts = list[Item]()
    for value in values:
        parts += [tomlkit.item(value), Whitespace(", ")]
    return Array(parts[:-1], Trivia())


def _plain(value: Any) -> Any:
    """Without what TOML has no word for: keys whose value is None or not a number are left out."""
    if isinstance(value, dict):
        known = {str(key): _plain(item) for key, item in value.items()}
        return {key: item for key, item in known.items() if item is not None}
    if isinstance(value, list | tuple):
        items = [_plain(item) for item in value]
        return items if any(isinstance(item, dict) for item in items) else _array(items)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
