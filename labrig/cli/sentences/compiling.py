"""A line for the user while numba compiles: without it half a minute passes in silence."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from labrig.cli.screen import warn

TOLD = "compiling what this command needs, up to half a minute; the next start of it finds it done"
_LOGGER = logging.getLogger("labrig.compiling")  # of the modules `jit`


class _OneLine(logging.Handler):
    """Prints the first record."""

    told = False

    def emit(self, record: logging.LogRecord) -> None:  # noqa: ARG002
        """Print one line to standard error, once."""
        if not self.told:
            self.told = True
            warn(TOLD)


@contextmanager
def compiling_is_told() -> Iterator[None]:
    """Say when something is compiled for the first time on this computer."""
    handler = _OneLine(logging.INFO)
    level, propagate = _LOGGER.level, _LOGGER.propagate
    _LOGGER.addHandler(handler)
    _LOGGER.setLevel(logging.INFO)
    _LOGGER.propagate = False
    try:
        yield
    finally:
        _LOGGER.removeHandler(handler)
        _LOGGER.setLevel(level)
        _LOGGER.propagate = propagate
