"""Packages whose names are loaded when they are first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from importlib import import_module
from typing import Any

_GETTING = frozenset({"load", "open", "read"})  # other packages call it by any of them


def lazily(
    package: str,
    homes: Mapping[str, Sequence[str]],
    *,
    modules: Sequence[str] = (),
    before: Callable[[], None] = lambda: None,
    elsewhere: Callable[[str], str] = lambda _: "",
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return `__getattr__`, `__dir__` and `__all__` of a package from the names of each module.

    `modules`: its modules that are names of it, too. `before` is called before a module is
    imported; it may raise. `elsewhere` says where a name that the package lacks is found, if any.
    """
    home_of = {name: home for home, names in homes.items() for name in names}
    every = sorted([*home_of, *modules])

    def load(name: str) -> Any:
        if name not in every:
            hint = elsewhere(name) or _hint(name, every)
            raise AttributeError(f"module {package!r} has no attribute {name!r}{hint}")
        before()
        if name in modules:
            return import_module(f"{package}.{name}")
        return getattr(import_module(home_of[name]), name)

    return load, lambda: list(every), every


def _hint(name: str, known: Sequence[str]) -> str:
    """Return "; did you mean open_session?" for names that hold the word or are spelt alike."""
    if name.startswith("_"):  # Python itself asks for many of these
        return ""
    wanted = {name.lower()}
    wanted |= _GETTING if wanted & _GETTING else set()
    words = [one for one in known if wanted & set(one.lower().split("_"))]
    close = words or get_close_matches(name, known, n=3, cutoff=0.7)
    return f"; did you mean {' or '.join(close)}?" if close else ""
