"""Find the parts of a plug-in folder: one a module, and those of other distributions.

A folder holds one kind of part (cameras, say). Each of its modules that defines the folder's
constant (`CAMERA`, say) adds one part under the module's name. Another distribution adds one by an
entry point of the folder's group; the entry point's name is the part's name. A part that cannot be
used is left out with a warning of one sentence.

`drivers`, `model` and `sim_hardware` stand alone, so each has this module; a test holds them equal.
"""

from __future__ import annotations

import pkgutil
import sys
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from threading import Timer
from traceback import extract_tb, walk_tb
from typing import TYPE_CHECKING, Generic, TypeVar, cast

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

T = TypeVar("T")
OWN = "labrig"  # the distribution of the parts in our own folders


class PluginWarning(UserWarning):
    """A part of another distribution is left out; the text names it with the reason."""


MOST_NAMED = 12  # parts that one sentence lists
_SLOW_S = 3.0  # to load a part, from which on it is said which one it is
_MOST_FAULTS = 3  # of one part in its sentence; the conformance functions return all
_ROOT = Path(__file__).parents[1]
_OURS = frozenset({"labrig", "drivers", "protocols", "model", "sim_hardware"})


class UnknownPartError(LookupError):
    """No part has this name; the text lists those there are."""


@dataclass(frozen=True)
class Part(Generic[T]):
    """A part and where it comes from."""

    name: str
    part: T
    distribution: str
    version: str


@dataclass(frozen=True, kw_only=True)
class PluginFolder(Generic[T]):
    """One kind of part: the package that holds our own, the entry-point group, the contract."""

    what: str  # "camera": a noun for messages
    package: str  # "drivers.cameras"
    constant: str  # "CAMERA"
    group: str  # "labrig.cameras"
    # what is wrong with a part, a sentence each; runs on other people's parts when they are loaded
    faults: Callable[[object], list[str]]
    # what no two parts may share beside the name, such as "the prefix 'iidc:'"; empty: nothing
    claim: Callable[[T], str] = lambda _: ""

    def parts(self) -> dict[str, Part[T]]:
        """Return all parts by name: our own in the order of their names, then other people's."""
        return dict(cast("dict[str, Part[T]]", _found(self, tuple(sys.path))))

    def get(self, name: str) -> T:
        """Return the part of this name; UnknownPartError lists those there are.

        No other part is loaded: what is wrong with one must not keep anybody from another.
        """
        part = self.find(name)
        if part is None:
            raise UnknownPartError(
                f"there is no {self.what} '{name}'; {_choice(name, sorted(self.parts()))}"
            )
        return part.part

    def find(self, name: str) -> Part[T] | None:
        """Return the part of this name, as `get` does; None where there is none."""
        return cast("Part[T] | None", _found_one(self, name, tuple(sys.path)))

    def own(self) -> dict[str, Part[T]]:
        """Return our own parts by name; no other distribution's code runs."""
        return cast("dict[str, Part[T]]", _own(cast("PluginFolder[object]", self)))

    def origins(self) -> dict[str, str]:
        """Return "distribution version" of each part that is not our own."""
        return {
            name: f"{part.distribution} {part.version}"
            for name, part in self.parts().items()
            if part.distribution != OWN
        }


def first_faults(checks: Iterable[Callable[[], Iterable[str]]]) -> list[str]:
    """Return the faults of the first check that finds some; what a part raises is one of them."""
    for check in checks:
        try:
            found = list(check())
        except (Exception, SystemExit) as error:  # noqa: BLE001 - it may raise anything
            return [f"its code raised {type(error).__name__}: {error}{place_of(error)}"]
        if found:
            return found
    return []


def place_of(error: BaseException) -> str:
    """Return where a part raised it; nothing where the part could not even be called."""
    last = extract_tb(error.__traceback__)[-1]
    file = Path(last.filename)
    if file.is_relative_to(_ROOT) and file.relative_to(_ROOT).parts[0] in _OURS:
        return ""
    return f" ({file.name}, line {last.lineno})"


def _place_in(error: BaseException, module: str) -> str:
    """Return where in a part's own files it was raised; nothing where it was not found, say."""
    package = module.partition(".")[0]
    for frame, line in reversed(list(walk_tb(error.__traceback__))):
        if frame.f_globals.get("__name__", "").partition(".")[0] == package:
            return f" ({Path(frame.f_code.co_filename).name}, line {line})"
    return ""


def _in_short(faults: list[str]) -> str:
    """Return the first faults, each once, and how many there are besides."""
    different = list(dict.fromkeys(fault.rstrip(".") for fault in faults))
    more = len(different) - _MOST_FAULTS
    return "; ".join(different[:_MOST_FAULTS]) + (f"; and {more} more" if more > 0 else "")


def _choice(name: str, known: list[str]) -> str:
    """Return what could be meant: the names alike, or all where they are few."""
    from difflib import get_close_matches

    if len(known) <= MOST_NAMED:
        close = get_close_matches(name, known, n=1)
        hint = f" (did you mean '{close[0]}'?)" if close else ""
        return f"choose one of: {', '.join(known)}{hint}"
    close = get_close_matches(name, known, n=3, cutoff=0.5)
    return f"did you mean {' or '.join(close)}" if close else f"there are {len(known)} others"


@lru_cache(maxsize=64)
def _found(folder: PluginFolder[object], path: tuple[str, ...]) -> dict[str, Part[object]]:
    """Return the parts as seen from these places; what is installed there is read once."""
    parts = _own(folder)
    claimed = {folder.claim(part.part): name for name, part in parts.items()}
    for entry in _entries(path).get(folder.group, ()):
        if entry.name in parts:
            article = "an" if folder.what[0] in "aeiou" else "a"
            _leave_out(folder, entry, f"there is {article} {folder.what} of that name already")
            continue
        part = _loaded(folder, entry, path)
        if part is None:
            continue
        claim = folder.claim(part.part)
        if claim and claim in claimed:
            _leave_out(folder, entry, f"{claim} is that of the {folder.what} '{claimed[claim]}'")
            continue
        claimed[claim] = entry.name
        parts[entry.name] = part
    return parts


@lru_cache(maxsize=256)
def _found_one(
    folder: PluginFolder[object], name: str, path: tuple[str, ...]
) -> Part[object] | None:
    """Return one part as `_found` does; its name may be anything that a file states."""
    part = _own_part(folder, name) if name in _own_modules(folder.package) else None
    if part is not None:
        return part
    of_that_name = [e for e in _entries(path).get(folder.group, ()) if e.name == name]
    loaded = (_loaded(folder, entry, path) for entry in of_that_name)
    return next((part for part in loaded if part is not None), None)


@lru_cache(maxsize=8)
def _entries(path: tuple[str, ...]) -> dict[str, list[EntryPoint]]:
    """Return the entry points of each group, as seen from these places, in their order.

    A file of each distribution is read for it, and there may be hundreds.
    """
    from importlib.metadata import entry_points  # slow to import

    del path
    found = entry_points()
    return {
        group: sorted(found.select(group=group), key=lambda e: (e.name, e.value))
        for group in found.groups
    }


def _own(folder: PluginFolder[object]) -> dict[str, Part[object]]:
    parts = (_own_part(folder, name) for name in _own_modules(folder.package))
    return {part.name: part for part in parts if part is not None}


def _own_modules(package: str) -> list[str]:
    """Return the names of our own modules in a folder that may define parts, in their order."""
    path = import_module(package).__path__
    names = sorted(module.name for module in pkgutil.iter_modules(path))
    return [name for name in names if not name.startswith("_")]


def _own_part(folder: PluginFolder[object], name: str) -> Part[object] | None:
    """Return the part of one of our own modules; None where it defines none."""
    module = import_module(f"{folder.package}.{name}")
    if not hasattr(module, folder.constant):
        return None
    return Part(name, getattr(module, folder.constant), OWN, "")


@lru_cache(maxsize=256)
def _loaded(
    folder: PluginFolder[object], entry: EntryPoint, path: tuple[str, ...]
) -> Part[object] | None:
    """Return the part an entry point leads to; None after a warning that says what is wrong."""
    del path
    slow = Timer(_SLOW_S, lambda: _warn(folder, entry, "takes long to load"))
    slow.daemon = True
    slow.start()
    try:
        part: object = entry.load()
        found = first_faults([lambda: folder.faults(part)])
    except KeyboardInterrupt:
        raise  # somebody's Ctrl-C
    except BaseException as error:  # noqa: BLE001 - other people's code may raise anything
        where = _place_in(error, entry.module)
        _leave_out(folder, entry, f"loading it failed with {type(error).__name__}: {error}{where}")
        return None
    finally:
        slow.cancel()
    if found:
        _leave_out(folder, entry, _in_short(found))
        return None
    dist = entry.dist
    return Part(entry.name, part, dist.name if dist else "?", dist.version if dist else "?")


def _leave_out(folder: PluginFolder[object], entry: EntryPoint, why: str) -> None:
    _warn(folder, entry, f"is left out: {' '.join(why.split())}")


def _warn(folder: PluginFolder[object], entry: EntryPoint, what: str) -> None:
    origin = f" of {entry.dist.name}" if entry.dist else ""
    warnings.warn(
        f"the {folder.what} '{entry.name}'{origin} ({entry.value}) {what}.",
        PluginWarning,
        stacklevel=7,
    )
