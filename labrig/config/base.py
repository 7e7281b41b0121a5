"""Closed configuration models, and errors that name file, key, value and what is allowed."""

from __future__ import annotations

import datetime as dt
import difflib
import json
import reprlib
import stat
import tomllib
from collections import Counter
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from labrig.config.file_kinds import TEXT, kind_of_bytes, other_kind
from labrig.config.toml_hints import toml_hint
from labrig.errors import BadInputError

MOST_BYTES = 8 << 20  # of a file that a person writes
_KEY = 60  # characters of a key that are worth showing
_MOST_KEYS = 8  # of a table that are listed beside an unknown one
_MOST = 20  # faults that are worth telling at once
_NO_WORDS = frozenset({int, float, bool, type(None)})


class ClosedModel(BaseModel):
    """A table of a configuration file: an unknown key is an error, a number must be finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @classmethod
    def keys(cls) -> list[str]:
        """Return the keys that the table may have."""
        return list(cls.model_fields)

    @classmethod
    def suggestion(cls, key: str) -> str:  # noqa: ARG003 - a table that knows more uses it
        """Return what else an unknown key of the table may be, for its error; often nothing."""
        return ""

    @field_validator("*", mode="before")
    @classmethod
    def _is_of_its_kind(cls, value: Any, info: ValidationInfo) -> Any:
        """Elsewhere `true` may count as 1 and "10" as 10; here each is a slip of the pen."""
        wanted = _kinds(cls.model_fields[str(info.field_name)].annotation)
        _insist(value, wanted)
        return value


def _kinds(annotation: Any) -> frozenset[type]:
    """Return the plain types that an annotation is made of, at any depth."""
    parts = get_args(annotation)
    if get_origin(annotation) is Literal:
        return frozenset(type(part) for part in parts)
    if not parts:
        return frozenset({annotation}) if isinstance(annotation, type) else frozenset()
    return frozenset().union(*map(_kinds, parts))


def _insist(value: Any, wanted: frozenset[type]) -> None:
    if isinstance(value, list):
        for item in value:
            _insist(item, wanted)
    elif isinstance(value, bool):
        if bool not in wanted:
            raise ValueError("should be neither true nor false")
    elif isinstance(value, str) and wanted <= _NO_WORDS:
        kind = "a number" if wanted & {int, float} else "true or false"
        raise ValueError(f"should be {kind}, without quotes")
    elif isinstance(value, int | float) and bool in wanted and not wanted & {int, float}:
        raise ValueError("should be true or false")
    elif isinstance(value, int | float) and dt.date in wanted:
        raise ValueError("should be a date such as 2026-11-21")


Model = TypeVar("Model", bound=ClosedModel)


def read_text(path: Path, wanted: str = TEXT, most_bytes: int = MOST_BYTES) -> str:
    """Return the content of a text file; BadInputError says why there is none.

    wanted: the kind of file that it should be, one of `file_kinds`.
    """
    raw = read_bytes(path, wanted, most_bytes)
    try:
        return raw.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        kind = kind_of_bytes(raw[:8])
        if kind:
            raise other_kind(path, kind, wanted) from None
        raise BadInputError(
            f"{path}: not a text file in UTF-8 (byte {error.start} cannot be read); save it "
            "as UTF-8."
        ) from None


def read_bytes(path: Path, wanted: str = TEXT, most_bytes: int = MOST_BYTES) -> bytes:
    """Return the content of a file; BadInputError says why there is none.

    Only an ordinary file is opened: a pipe would be waited for, a device read without end.
    """
    try:
        _check_kind(path, wanted, most_bytes)
        with path.open("rb") as file:
            return file.read(most_bytes)
    except FileNotFoundError:
        raise BadInputError(f"{path}: there is no such file.") from None
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read ({error.strerror}).") from None
    except ValueError as error:  # a path that cannot be one
        raise BadInputError(f"{str(path)!r}: cannot be read ({error}).") from None


def _check_kind(path: Path, wanted: str, most_bytes: int) -> None:
    found = path.stat()
    if stat.S_ISDIR(found.st_mode):
        raise BadInputError(f"{path}: this is a folder, a file is needed.")
    if not stat.S_ISREG(found.st_mode):
        raise BadInputError(f"{path}: this is a device or a pipe, an ordinary file is needed.")
    if found.st_size > most_bytes:
        with path.open("rb") as file:
            kind = kind_of_bytes(file.read(8))
        if kind:
            raise other_kind(path, kind, wanted)
        raise BadInputError(
            f"{path}: has {found.st_size / 1e6:.0f} MB; such a file has at most "
            f"{most_bytes / 1e6:.0f} MB."
        )


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """TOML text as a dictionary; `name` is the file's name for the error."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise BadInputError(f"{name}: not valid TOML: too many brackets in one another.") from None
    except ValueError as error:  # also of a number with thousands of digits
        hint = toml_hint(text, str(error))
        raise BadInputError(f"{name}: not valid TOML: {error}{hint}.") from None


def parse_json(text: str, name: str) -> Any:
    """JSON text as what it holds; `name` is the file's name for the error."""
    try:
        return json.loads(text)
    except RecursionError:
        raise BadInputError(f"{name}: not valid JSON: too many brackets in one another.") from None
    except ValueError as error:  # also of a number with thousands of digits
        raise BadInputError(f"{name}: not valid JSON: {error}.") from None


def validate(model: type[Model], data: dict[str, Any], name: str) -> Model:
    """Return the data as a model; BadInputError has a sentence for each fault."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise BadInputError("\n".join(_sentences(model, error, name))) from None


def _sentences(model: type[BaseModel], error: ValidationError, name: str) -> list[str]:
    """One for each key; the alternatives of a key that may be of several types go into one."""
    faults: dict[str, list[Any]] = {}
    for fault in _without_tables(error.errors()):
        faults.setdefault(_where(fault["loc"]), []).append(fault)
    told = [f"{name}: {_sentence(model, where, faults[where])}." for where in list(faults)[:_MOST]]
    if len(faults) > _MOST:
        told.append(f"{name}: {len(faults) - _MOST} more keys are wrong.")
    return told


def _without_tables(faults: Sequence[Any]) -> list[Any]:
    """Return the faults; of a key that is `true` or a table, a table is told only what is in it."""

    def is_table(fault: Any) -> bool:
        return fault["type"] == "bool_type" and isinstance(fault["input"], dict)

    tables = {fault["loc"][:-1] for fault in faults if is_table(fault)}
    if not tables:
        return list(faults)
    inside = Counter(
        fault["loc"][:n] for fault in faults for n in range(len(fault["loc"]) + 1)
        if fault["loc"][:n] in tables
    )  # fmt: skip
    return [f for f in faults if not is_table(f) or inside[f["loc"][:-1]] == 1]


def _sentence(model: type[BaseModel], where: str, faults: list[Any]) -> str:
    first = faults[0]
    if first["type"] == "extra_forbidden":
        known, further = (each(model, first["loc"]) for each in (_suggestion, _further))
        if further:
            known += f", or {further}" if known else f"; it may be {further}"
        return f"{where} is not a known key{known}"
    if first["type"] == "missing":
        return _missing(where, first["loc"])
    said = " or ".join(dict.fromkeys(map(_said, _best(faults))))
    if not first["loc"]:
        return said
    given = "" if isinstance(first["input"], dict) else f" = {_short(first['input'])}"
    return f"{where}{given}: {said}"


def _best(faults: list[Any]) -> list[Any]:
    """Return what is wrong with the alternative that was meant, where a check of ours tells."""
    ours = [fault for fault in faults if fault["type"] == "value_error"]
    return ours if ours and isinstance(faults[0]["input"], dict) else faults


def _missing(where: str, location: tuple[Any, ...]) -> str:
    if location and isinstance(location[-1], int):
        return f"{_where(location[:-1])} lacks value {location[-1] + 1}"
    return f"{where} is missing; it is required"


def _short(value: Any) -> str:
    """Return a value for a message: whole, but not a page of it."""
    if isinstance(value, bool):
        return str(value).lower()
    writer = reprlib.Repr()
    writer.maxstring = writer.maxother = writer.maxlong = 80
    return writer.repr(value)


def _cut(key: str) -> str:
    return key if len(key) <= _KEY else f"{key[:_KEY]}..."


# What pydantic says in the words of its own language, by the type of the fault.
_PLAINLY = {
    "string_type": "should be a text in quotes",
    "path_type": "should be a path in quotes",
    "float_type": "should be a number",
    "float_parsing": "should be a number",
    "int_type": "should be a whole number",
    "int_parsing": "should be a whole number",
    "int_from_float": "should be a whole number",
    "bool_type": "should be true or false",
    "bool_parsing": "should be true or false",
    "tuple_type": "should be a list in brackets",
    "list_type": "should be a list in brackets",
    "date_type": "should be a date such as 2026-11-21",
    "date_parsing": "should be a date such as 2026-11-21",
    "date_from_datetime_parsing": "should be a date such as 2026-11-21",
    "date_from_datetime_inexact": "should be a date such as 2026-11-21",
    "model_type": "should be a table",
    "model_attributes_type": "should be a table",
    "dict_type": "should be a table",
}


def _said(fault: Any) -> str:
    kind, context = fault["type"], fault.get("ctx", {})
    if kind in _PLAINLY:
        return _PLAINLY[kind]
    if kind == "too_short":
        return f"should have at least {context['min_length']} of them"
    if kind == "too_long":
        return f"should have at most {context['max_length']} of them"
    said: str = fault["msg"].removeprefix("Value error, ").removeprefix("Input ").rstrip(".")
    return said


def _where(location: tuple[Any, ...]) -> str:
    """Return a place in words: "entry 2 of [[places]]: value 1 of positions_mm"."""
    tables, values = "", ""
    keys: list[str] = []
    # Parts that pydantic adds for the branch of a union are no keys of the file.
    parts = [part for part in location if not _is_branch(part)]
    for at, part in enumerate(parts):
        if not isinstance(part, int):
            keys.append(_cut(str(part)))
        elif any(isinstance(later, str) for later in parts[at:]):
            tables += f"entry {part + 1} of [[{'.'.join(keys)}]]: "
            keys = []
        else:
            values = f"value {part + 1} of {values}"
    return tables + values + _key(keys)


def _key(keys: list[str]) -> str:
    if len(keys) < 2:
        return keys[0] if keys else "the file"
    return f"[{'.'.join(keys[:-1])}] {keys[-1]}"


def _is_branch(part: Any) -> bool:
    return isinstance(part, str) and (
        part in {"float", "int", "str", "bool", "is_instance"}
        or part.startswith(("literal[", "list[", "dict[", "function-"))
        or (part[:1].isupper() and part.isalnum())
    )


def _suggestion(model: type[BaseModel], location: tuple[Any, ...]) -> str:
    wrong = _cut(str(location[-1]))
    own = list(dict.fromkeys(key for table in _tables(model, location) for key in _keys_of(table)))
    elsewhere = sorted(_known_keys(model) - {wrong})  # known elsewhere is not known here
    for keys, likeness in ((own, 0.6), (elsewhere, 0.75)):
        if close := difflib.get_close_matches(wrong, keys, n=1, cutoff=likeness):
            return f"; did you mean {close[0]}"
    if len(location) > 1 and 0 < len(own) <= _MOST_KEYS:
        return f"; known are {', '.join(own)}"
    return ""


def _further(model: type[BaseModel], location: tuple[Any, ...]) -> str:
    tables = (table for table in _tables(model, location) if issubclass(table, ClosedModel))
    return next(filter(None, (table.suggestion(str(location[-1])) for table in tables)), "")


def _tables(model: type[BaseModel], location: tuple[Any, ...]) -> list[type[BaseModel]]:
    """Return the models that the table at a location may have: several where `kind` chooses one."""
    tables = [model]
    for part in location[:-1]:
        fields = [table.model_fields[part] for table in tables if part in table.model_fields]
        tables = [kind for field in fields for kind in _models(field)] or tables
    return tables


def _known_keys(model: type[BaseModel]) -> set[str]:
    keys = set(_keys_of(model))
    for field in model.model_fields.values():
        for kind in _models(field):
            keys |= _known_keys(kind)
    return keys


def _keys_of(model: type[BaseModel]) -> list[str]:
    return model.keys() if issubclass(model, ClosedModel) else list(model.model_fields)


def _models(field: FieldInfo) -> list[type[BaseModel]]:
    """Return the models among the types that a key may have."""
    chosen = (part.models().values() for part in field.metadata if hasattr(part, "models"))
    kinds = (field.annotation, *get_args(field.annotation), *chain.from_iterable(chosen))
    return [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
