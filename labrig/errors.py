"""What a user can cause, and the exit code each ends with.

Every text is one sentence: what is wrong, where (file, key, channel), what to do.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable
from enum import IntEnum

# our packages, and what stands between them and who calls them
_OURS = frozenset({"labrig", "model", "protocols", "drivers", "sim_hardware", "contextlib"})


class ExitCode(IntEnum):
    """The codes the command line ends with."""

    DONE = 0
    BAD_INPUT = 2  # arguments or a file's content
    NOT_READY = 3  # found before the first voltage: no driver, refused, wrong device, preflight
    STOPPED = 4  # by a person or a signal
    FAILED = 5  # of a run: after the first voltage; else the work could not be done: a full disk
    OUTPUT_UNKNOWN = 6  # the output is not known to be safe, whatever else happened


class RenamedKeyWarning(DeprecationWarning):
    """A key of a configuration file has a new name; the old one is read for one release."""


class LabrigWarning(UserWarning):
    """Something about data or a model that is no error; the text is a sentence for the user."""


class ArgumentWarning(LabrigWarning):
    """A warning whose text names arguments of a Python function."""

    def __init__(self, text: str, *names: str) -> None:
        super().__init__(text)
        self.names = names

    def in_words(self, spelled: Callable[[str], str]) -> str:
        """Return the text with each argument as somebody else spells it, such as an option."""
        return _respelled(str(self), self.names, spelled)


def warn_caller(warning: Warning) -> None:
    """Warn at the line of the code that called labrig: one of labrig's own says nothing to it."""
    frame, depth = sys._getframe(), 1
    while frame.f_back is not None and is_ours(frame.f_globals.get("__name__", "")):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(warning, stacklevel=depth)


def type_in_words(value: object) -> str:
    """Return what something is, with its article: an int, a DataFrame, None."""
    if value is None:
        return "None"
    name = type(value).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def is_ours(module: str) -> bool:
    """Whether a module is one of labrig's packages."""
    return module.partition(".")[0] in _OURS


class LabrigError(Exception):
    """An error for the user, with the exit code it ends the program with."""

    code = ExitCode.FAILED


class BadInputError(LabrigError):
    """An argument or a file's content is wrong."""

    code = ExitCode.BAD_INPUT


class BadArgumentError(BadInputError):
    """An argument of a Python function is wrong; the text names it as the function does."""

    def __init__(self, text: str, *names: str) -> None:
        super().__init__(text)
        self.names = names

    def in_words(self, spelled: Callable[[str], str]) -> str:
        """Return the text with each argument as somebody else spells it, such as an option."""
        return _respelled(str(self), self.names, spelled)


class ReadOnlyError(BadInputError):
    """A file cannot be changed where it lies, such as in an archive."""


class NotReadyError(LabrigError):
    """The rig is not ready; nothing was energised."""

    code = ExitCode.NOT_READY


class StoppedError(LabrigError):
    """A person or a signal stopped the work."""

    code = ExitCode.STOPPED


class OutputUnknownError(LabrigError):
    """The drive voltage is not known to be 0 V."""

    code = ExitCode.OUTPUT_UNKNOWN


def _respelled(text: str, names: tuple[str, ...], spelled: Callable[[str], str]) -> str:
    """Return the text with the next mention of each name, in a path none, spelled anew."""
    for name in names:
        word = rf"(?<![\w./\\-]){re.escape(name)}(?![\w/\\-]|\.\w)"
        text = re.sub(word, spelled(name), text, count=1)
    return text
