"""Compile functions with numba, and keep what is compiled from one start to the next.

numba keeps compiled code beside the sources, or in the user's cache where those cannot be written.
It compiles a function again when the function's own file changes. It does not notice that a
function, a constant or a named tuple of another file changes, although it compiles that in. So
`jit` deletes what was compiled from a file as soon as one of the files it depends on has changed.

To compile takes half a minute the first time. The logger `labrig.compiling` is told so once, and
only where nothing was kept before.

`model`, `sim_hardware` and `labrig.vision` stand alone, so each has this module; a test holds them
equal. Importing it imports numba, which takes the best part of a second.
"""

from __future__ import annotations

import ast
import gc
import hashlib
import logging
from collections.abc import Callable, Iterator
from functools import cache, lru_cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.registry import CPUDispatcher
from numba.core.runtime import rtsys

Array = np.ndarray[Any, Any]
Function = TypeVar("Function", bound=Callable[..., Any])

SUMS_IN_ANY_ORDER = frozenset({"reassoc", "contract", "nsz", "arcp"})  # NaN and infinity are kept
_GARBAGE = 400_000  # objects made before the search for garbage, while something is compiled
_FOLDER = Path(__file__).resolve().parent  # of this package
_ROOT = _FOLDER.parents[__name__.count(".") - 1]  # the folder from which modules are imported
_TOP = _ROOT / __name__.partition(".")[0]  # imports from elsewhere are not followed


def jit(function: Function) -> Function:
    """Compile a function at its first call; its sums may be taken in any order."""
    return _compiled(function, SUMS_IN_ANY_ORDER)


def strict_jit(function: Function) -> Function:
    """Compile a function at its first call; its arithmetic is done as it is written."""
    return _compiled(function, frozenset())


def brief_jit(function: Function) -> Function:
    """Compile a function that runs for microseconds: as `strict_jit`, but it keeps the GIL.

    To get the GIL back can take milliseconds while another thread computes.
    """
    return _compiled(function, frozenset(), nogil=False)


def jit_inside(function: Function) -> Function:
    """Compile as `jit`, as a part of the function that calls it.

    It costs less to compile where that is one, for what a function calls is compiled again with it.
    """
    return _compiled(function, SUMS_IN_ANY_ORDER, inline="always")


def drop_stale(cache: Path, source: Path) -> bool:
    """Delete what was compiled from a file, if a file it depends on has changed since.

    Returns whether only current code is left; False where it cannot be deleted.
    """
    digest = hashlib.sha256(b"".join(_bytes(path) for path in sorted(sources(source)))).hexdigest()
    mark = cache / f"{source.stem}.sources"
    try:
        if mark.exists() and mark.read_text(encoding="ascii") == digest:
            return True
        for old in cache.glob(f"{source.stem}.*.nb[ic]"):
            old.unlink(missing_ok=True)
        cache.mkdir(parents=True, exist_ok=True)
        mark.write_text(digest, encoding="ascii")
    except OSError:
        return False
    return True


def sources(source: Path) -> set[Path]:
    """Return the files on which code that is compiled from a file depends.

    They are the file, what it imports at its top, what that imports, and all files of this package
    that define named tuples: these may be handed to compiled code by whoever calls it.
    """
    found: set[Path] = set()
    new = {source}
    while new:
        one = new.pop()
        found.add(one)
        new |= _imports(one) - found
    return found | _named_tuples()


def _compiled(
    function: Function, fastmath: frozenset[str], *, nogil: bool = True, inline: str = "never"
) -> Function:
    """Return a function that compiled functions and Python call, compiled for each when needed.

    Only the one for Python has the code that turns Python's objects into numbers and back: for the
    many functions that only compiled functions call, it would take half of the time to compile.
    """
    options = {
        "nogil": nogil, "error_model": "numpy", "fastmath": set(fastmath), "inline": inline,
    }  # fmt: skip
    inner = _renamed(function)
    made = _kept(inner, no_cfunc_wrapper=True, no_cpython_wrapper=True, **options)
    if made is inner:  # numba is switched off
        return function
    made.__class__ = _Inner
    for_python = partial(_kept, function, no_cfunc_wrapper=True, **options)
    made.for_python = lru_cache(maxsize=1)(for_python)
    return cast("Function", made)


def _kept(function: Any, **options: Any) -> Any:
    """Return a function to be compiled at its first call, and kept where that is possible."""
    made = numba.njit(cache=True, **options)(function)
    if made is not function:
        made._cache.__class__ = _Cache
        source = Path(function.__code__.co_filename).resolve()
        if not _dropped(Path(made.stats.cache_path), source):
            made = numba.njit(**options)(function)
    return made


def _renamed(function: Any) -> Any:
    """Return a copy of a function; numba names the files after it, which must differ."""
    copy = FunctionType(
        function.__code__, function.__globals__, function.__name__, function.__defaults__,
        function.__closure__,
    )  # fmt: skip
    copy.__kwdefaults__ = function.__kwdefaults__
    copy.__module__, copy.__doc__ = function.__module__, function.__doc__
    copy.__qualname__ = f"{function.__qualname__}.inner"
    return copy


class _Inner(CPUDispatcher):  # type: ignore[misc]  # numba has no types
    """What compiled functions call. A call from Python goes to the one for Python."""

    for_python: Callable[[], Any]

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        """Call the function from Python. Raises KeyboardInterrupt where Ctrl-C came meanwhile.

        numba turns that into a SystemError, which would pass for a fault of the function.
        """
        try:
            return self.for_python()(*args, **keywords)
        except SystemError as error:
            if _was_stopped(error):
                raise KeyboardInterrupt from error
            raise


class _Cache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Loads what is kept without all that numba needs to compile, which it loads when it does so.

    That takes a third of a second of each process that uses compiled functions.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept for a signature; None: nothing is. numba holds its lock meanwhile."""
        target_context.refresh = partial(rtsys.initialize, target_context)  # memory of arrays
        try:
            return super().load_overload(sig, target_context)
        finally:
            del target_context.refresh


class _Compilations(event.Listener):  # type: ignore[misc]  # numba has no types
    """Says that something is compiled, where none of it was kept; and collects garbage seldom.

    numba makes so many objects that the search for garbage takes a tenth of the compilation.
    """

    told = False
    depth = 0  # a function is compiled while one that calls it is
    threshold: tuple[int, int, int] | None = None  # to go back to; only one package changes it

    def on_start(self, event: Any) -> None:
        """Look whether this is the first compilation; called before each one."""
        if self.depth == 0 and gc.get_threshold()[0] != _GARBAGE:
            self.threshold = gc.get_threshold()
            gc.set_threshold(_GARBAGE, *self.threshold[1:])
        self.depth += 1
        cache = event.data["dispatcher"].stats.cache_path  # None: it is not one of ours
        if not self.told and cache is not None:
            self.told = True
            if not any(Path(cache).glob("*.nbc")):
                logging.getLogger("labrig.compiling").info("compiling once")

    def on_end(self, event: Any) -> None:  # noqa: ARG002 - numba's
        """See `on_start`; called after each one."""
        self.depth -= 1
        if self.depth == 0 and self.threshold is not None:
            gc.set_threshold(*self.threshold)
            self.threshold = None


def _was_stopped(error: BaseException | None) -> bool:
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__
    return error is not None


event.register("numba:compile", _Compilations())
_dropped = lru_cache(maxsize=None)(drop_stale)  # once for each file
_bytes = lru_cache(maxsize=None)(Path.read_bytes)


@cache
def _imports(source: Path) -> set[Path]:
    """Return the files of the top package from which a file imports when it is loaded."""
    modules = (m for node in ast.parse(_bytes(source)).body for m in _modules(node, source))
    paths = (p for m in modules for p in (m.with_suffix(".py"), m / "__init__.py"))
    return {path for path in paths if path.is_file()}


def _modules(node: ast.stmt, source: Path) -> Iterator[Path]:
    """Return where the modules that a statement may import would be, without their suffix."""
    if isinstance(node, ast.Import):
        named = [_ROOT.joinpath(*one.name.split(".")) for one in node.names]
    elif isinstance(node, ast.ImportFrom):
        base = source.parents[node.level - 1] if node.level else _ROOT
        module = base.joinpath(*(node.module or "").split("."))
        named = [module, *(module / one.name for one in node.names)]
    else:
        return
    yield from (one for one in named if _TOP in (one, *one.parents))


@cache
def _named_tuples() -> set[Path]:
    return {path for path in _FOLDER.rglob("*.py") if b"NamedTuple" in _bytes(path)}
