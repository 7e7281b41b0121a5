"""The public names of labrig, model and labrig.testing, from their signatures and docstrings."""

from __future__ import annotations

import ast
import dataclasses
import enum
import inspect
import io
import re
import textwrap
import tokenize
from collections.abc import Iterator
from typing import Any

import labrig
import labrig.testing
import model

HEAD = """\
# Python

`import labrig` gives what evaluates a session and the contract of each kind of part.
`import model` gives the mechanics alone. `labrig.testing` has what tests of parts of your own need.
Numbers are in SI units: V, N, m, s, rad. Each name is loaded when it is first used.
"""
_PACKAGES = (labrig, model, labrig.testing)
_FOR_TOOLS = ("fmt:", "noqa", "type:", "pragma:")  # comments that say nothing to a reader
_MODULE = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z_])")  # before the name of a type


def page() -> str:
    """Return the page's text."""
    return "\n".join([HEAD, *(line for package in _PACKAGES for line in _package(package))])


def public_names() -> list[tuple[str, Any]]:
    """Return all names with what they are; what two packages hand on is in both."""
    return [
        (f"{package.__name__}.{name}", getattr(package, name))
        for package in _PACKAGES
        for name in package.__all__
    ]


def _package(package: Any) -> Iterator[str]:
    yield f"\n## {package.__name__}\n"
    for name in sorted(package.__all__, key=str.lower):
        thing = getattr(package, name)
        first = f"{package.__name__}.{name}"
        if package is model and getattr(labrig, name, None) is thing:
            yield f"`{first}` is `labrig.{name}`.\n"
        elif inspect.isclass(thing):
            yield from _class(first, thing)
        elif callable(thing):
            yield from _function(first, thing, "function")
        else:
            yield f"````{{py:data}} {first}\n{inspect.getdoc(thing) or ''}\n````\n"


def _class(name: str, thing: type) -> Iterator[str]:
    shown = "" if issubclass(thing, Exception | enum.Enum) or inspect.isabstract(thing) else None
    signature = _signature(thing) if shown is None and not _is_protocol(thing) else ""
    yield f"`````{{py:class}} {name}{signature}"
    yield _doc(thing)
    yield from _fields(thing)
    for member, value in vars(thing).items():
        inner = value.fget if isinstance(value, property) else _plain(value)
        documented = inspect.isfunction(inner) and bool(inspect.getdoc(inner))
        if documented and not member.startswith("_"):
            kind = "property" if isinstance(value, property) else "method"
            yield from _function(member, inner, kind)
    yield "`````\n"


def _fields(thing: type) -> Iterator[str]:
    """Yield what the comments say of the fields of a data class; the signature has their types."""
    said = field_comments(thing) if dataclasses.is_dataclass(thing) else {}
    if said:
        yield ""
        yield from (f"- `{name}`: {text}".replace("<", "\\<") for name, text in said.items())
        yield ""


def field_comments(thing: type) -> dict[str, str]:
    """Return the comment behind or directly above each public field of a class, in one line."""
    source = textwrap.dedent(inspect.getsource(thing))
    lines, comments = source.splitlines(), _comments(source)
    names = [field.name for field in dataclasses.fields(thing) if not field.name.startswith("_")]
    found = {}
    for field in ast.walk(ast.parse(source)):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            last = field.end_lineno or field.lineno
            parts = [comments[n] for n in range(field.lineno, last + 1) if n in comments]
            above = field.lineno - 1
            while lines[above - 1].lstrip().startswith("#"):
                parts.insert(0, comments.get(above, ""))
                above -= 1
            text = " ".join(filter(None, parts))
            if text and field.target.id in names:
                found[field.target.id] = text
    return found


def _comments(source: str) -> dict[int, str]:
    """Return the comments by line, without those that are for tools."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    every = {t.start[0]: t.string.lstrip("# ") for t in tokens if t.type == tokenize.COMMENT}
    return {line: text for line, text in every.items() if not text.startswith(_FOR_TOOLS)}


def _plain(value: Any) -> Any:
    return value.__func__ if isinstance(value, classmethod | staticmethod) else value


def _is_protocol(thing: type) -> bool:
    return bool(getattr(thing, "_is_protocol", False))


def _function(name: str, thing: Any, kind: str) -> Iterator[str]:
    signature = "" if kind == "property" else _signature(thing)
    yield f"````{{py:{kind}}} {name}{signature}"
    yield _doc(thing)
    yield "````\n"


def _signature(thing: Any) -> str:
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return "()"
    parameters = [_parameter(p) for p in signature.parameters.values() if p.name != "self"]
    returned = signature.return_annotation
    after = "" if returned in (inspect.Signature.empty, None, "None") else f" -> {_type(returned)}"
    plain = signature.replace(parameters=parameters, return_annotation=inspect.Signature.empty)
    return str(plain).replace("'", "") + ("" if inspect.isclass(thing) else after)


def _parameter(parameter: inspect.Parameter) -> inspect.Parameter:
    """Return a parameter whose annotation and default are short words."""
    empty = inspect.Parameter.empty
    if parameter.default is not empty and not isinstance(
        parameter.default, str | int | float | bool | None
    ):
        parameter = parameter.replace(default=Ellipsis)
    if parameter.annotation is not empty:
        parameter = parameter.replace(annotation=_Word(_type(parameter.annotation)))
    return parameter


class _Word(str):
    """A text that a signature shows as it is."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def _type(annotation: Any) -> str:
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return _MODULE.sub("", text)


def _doc(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").replace("<", "\\<")
