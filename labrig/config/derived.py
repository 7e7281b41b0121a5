"""Closed configuration models made from the dataclasses in which parts declare their settings.

`drivers` and `protocols` keep to the standard library, so a part says in a dataclass what can be
set, and in each field's `metadata` what is allowed:

    rate_hz: float = field(default=30.0, metadata={"gt": 0, "le": 240, "unit": "1/s",
                                                   "description": "frames per second"})

Known keys: ge, gt, le, lt, min_length, max_length, pattern, multiple_of (bounds; those of numbers
hold for each item of a tuple under "items": {...}), description, unit, check (a function that
raises ValueError with what the value must be), formerly (an older name of the key), path (True, or
a function that tells whether a value is one: a relative path is taken from the file's folder).
"""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    Field,
    GetJsonSchemaHandler,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError, core_schema

from labrig.config.base import ClosedModel
from labrig.errors import RenamedKeyWarning

_BOUNDS = ("ge", "gt", "le", "lt", "multiple_of", "min_length", "max_length", "pattern")
KIND_SAID = "which of the parts that are installed"
SIMULATED = "simulated"  # instead of an address, a port or a source; no part's check sees it


@contextmanager
def raising_value_errors() -> Iterator[None]:
    """Make a fault of the file of whatever a part's own code raises: it has read the file's values.

    A ValueError passes as it is.
    """
    try:
        yield
    except ValueError:
        raise
    except (Exception, SystemExit) as fault:
        raise ValueError(f"its part failed with {type(fault).__name__}: {fault}") from fault


class SettingsModel(ClosedModel):
    """A table of a configuration file whose keys are the fields of a dataclass, and `kind`."""

    settings_type: ClassVar[type]
    former_names: ClassVar[Mapping[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _rename(cls, data: Any) -> Any:
        """Read a key under its older name, with a warning."""
        if not isinstance(data, dict):
            return data
        for old, new in cls.former_names.items():
            if old in data and new not in data:
                text = f"the key {old} is now called {new}; please rename it."
                warnings.warn(text, RenamedKeyWarning, stacklevel=2)
                data = {**{key: data[key] for key in data if key != old}, new: data[old]}
        return data

    @model_validator(mode="after")
    def _fits_together(self) -> typing.Self:
        """Make the dataclass: what it refuses (ValueError) is a fault of this table."""
        with raising_value_errors():
            self.settings()
        return self

    def settings(self) -> Any:
        """Return the dataclass that the part is made from."""
        names = [field.name for field in dataclasses.fields(self.settings_type) if field.init]
        return self.settings_type(**{name: _plain(getattr(self, name)) for name in names})

    def with_paths_from(self, folder: Path) -> typing.Self:
        """Return the same with the paths among its keys taken from a folder."""
        update: dict[str, object] = {}
        for field in dataclasses.fields(self.settings_type):
            value, path = getattr(self, field.name, None), field.metadata.get("path")
            if isinstance(value, str | Path) and path and value not in ("", SIMULATED):
                with raising_value_errors():
                    is_path = not callable(path) or path(value)
                if is_path:
                    update[field.name] = type(value)(folder / value)
        return self.model_copy(update=update)


Base = typing.TypeVar("Base", bound=SettingsModel)


def _plain(value: Any) -> Any:
    if isinstance(value, SettingsModel):
        return value.settings()
    if isinstance(value, tuple):
        return tuple(map(_plain, value))
    return value


def model_of(settings: type, kind: str | None = None) -> type[SettingsModel]:
    """Return the closed model of a dataclass; with `kind`, a key of that name and value."""
    return _model_of(settings, kind, SettingsModel)


def model_with(base: type[Base], settings: type, kind: str | None = None) -> type[Base]:
    """Return the same with the further keys of `base`, which its `settings` leave out."""
    return typing.cast("type[Base]", _model_of(settings, kind, base))


@functools.lru_cache(maxsize=256)
def _model_of(settings: type, kind: str | None, base: type[SettingsModel]) -> type[SettingsModel]:
    fields: dict[str, Any] = (
        {} if kind is None else {"kind": (Literal[kind], Field(kind, description=KIND_SAID))}
    )
    hints = typing.get_type_hints(settings, include_extras=True)
    former: dict[str, str] = {}
    for field in dataclasses.fields(settings):
        if not field.init:
            continue
        fields[field.name] = (_annotation(hints[field.name], field.metadata), _field(field))
        if "formerly" in field.metadata:
            former[field.metadata["formerly"]] = field.name
    model = create_model(settings.__name__, __base__=base, __doc__=_doc(settings), **fields)
    model.settings_type = settings
    model.former_names = former
    return model


def _doc(settings: type) -> str | None:
    """Return the dataclass's docstring; None for the one the standard library makes."""
    doc = settings.__doc__
    return None if doc is None or doc.startswith(f"{settings.__name__}(") else doc


def _field(field: dataclasses.Field[Any]) -> Any:
    said = field.metadata
    facts: dict[str, Any] = {key: said[key] for key in (*_BOUNDS, "description") if key in said}
    if "unit" in said:
        facts["json_schema_extra"] = {"unit": said["unit"]}
    if field.default is not dataclasses.MISSING:
        return Field(_as_model(field.default), **facts)
    if field.default_factory is not dataclasses.MISSING:
        make = field.default_factory
        return Field(default_factory=lambda: _as_model(make()), **facts)
    return Field(..., **facts)


def _as_model(value: Any) -> Any:
    """Return a default that is a dataclass itself as its model."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        plain = {f.name: _as_model(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return model_of(type(value)).model_construct(**plain)
    return tuple(map(_as_model, value)) if isinstance(value, tuple) else value


def _annotation(wanted: Any, said: Mapping[str, Any]) -> Any:
    wanted = _with_models(wanted, said.get("items"))
    if "check" in said:
        return Annotated[wanted, AfterValidator(_checked(said["check"]))]
    return wanted


def _with_models(wanted: Any, items: Mapping[str, Any] | None) -> Any:
    """Replace each dataclass in a type by its model, and put bounds on its items."""
    if dataclasses.is_dataclass(wanted) and isinstance(wanted, type):
        return model_of(wanted)
    origin, parts = typing.get_origin(wanted), typing.get_args(wanted)
    if origin in (types.UnionType, typing.Union):
        return typing.Union[tuple(_with_models(part, items) for part in parts)]  # noqa: UP007
    if origin in (tuple, list):
        inner = tuple(
            part if part is Ellipsis else _item(_with_models(part, None), items) for part in parts
        )
        return origin[inner]
    return wanted


def _item(wanted: Any, items: Mapping[str, Any] | None) -> Any:
    return Annotated[wanted, Field(**items)] if items else wanted


def _checked(check: Callable[[Any], object]) -> Callable[[Any], Any]:
    def after(value: Any) -> Any:
        if value != SIMULATED and value is not None:
            with raising_value_errors():
                check(value)
        return value

    return after


@dataclasses.dataclass(frozen=True)
class OneOf:
    """Annotation of a key whose table is read by one of several models.

    `models` returns them by name when a file is read, so that what is installed by then counts;
    `choose` returns the name for a table, or raises ValueError with what is wrong with the table's
    `kind`. A key that only another of the models knows is left unread: so the choice can be changed
    in one line.
    """

    models: Callable[[], Mapping[str, type[ClosedModel]]]
    choose: Callable[[Mapping[str, Any]], str]

    def read(self, table: Any) -> ClosedModel:
        """Return the model of a table. Raises ValueError, of which ValidationError is one."""
        if isinstance(table, ClosedModel):
            return table
        if not isinstance(table, dict):
            raise ValueError("should be a table")  # noqa: TRY004 - pydantic wants a ValueError
        models = self.models()
        try:
            own = models[self.choose(table)]
        except ValueError as fault:
            raise _wrong_kind(table, str(fault)) from None
        others = {key for model in models.values() for key in model.model_fields}
        unread = others - set(own.model_fields) - {"kind"}
        return own.model_validate({key: table[key] for key in table if key not in unread})

    def __get_pydantic_core_schema__(self, _source: Any, _handler: Any) -> Any:
        """How pydantic reads and writes such a key."""
        return core_schema.no_info_plain_validator_function(
            self.read,
            serialization=core_schema.plain_serializer_function_ser_schema(
                lambda table, info: table.model_dump(mode=info.mode), info_arg=True
            ),
        )

    def __get_pydantic_json_schema__(self, _schema: Any, handler: GetJsonSchemaHandler) -> Any:
        """Return the schema: any of the models."""
        every = [handler(model.__pydantic_core_schema__) for model in self.models().values()]
        return every[0] if len(every) == 1 else {"anyOf": every}


def _wrong_kind(table: Mapping[str, Any], why: str) -> ValidationError:
    """Return the error of the key `kind` of a table."""
    details = InitErrorDetails(
        type=PydanticCustomError("wrong_kind", "{why}", {"why": why}),
        loc=("kind",),
        input=table.get("kind"),
    )
    return ValidationError.from_exception_data("kind", [details])


def by_kind(
    what: str, models: Callable[[], Mapping[str, type[ClosedModel]]], default: str | None = None
) -> OneOf:
    """Return the annotation of a key whose table says by its `kind` which model reads it."""

    def choose(table: Mapping[str, Any]) -> str:
        kind = table.get("kind", default)
        there = sorted(models())
        if kind is None:
            raise ValueError(f"choose one of {', '.join(there)}")
        if kind not in there:
            raise ValueError(f"there is no {what} of this kind; choose one of {', '.join(there)}")
        return str(kind)

    return OneOf(models, choose)
