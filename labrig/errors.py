"""What a user can cause, and the exit code each ends with.

Every text is one sentence: what is wrong, where (file, key, channel), what to do.
"""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """The codes the command line ends with."""

    DONE = 0
    BAD_INPUT = 2  # arguments or a file's content
    NOT_READY = 3  # found before the first voltage: no driver, refused, wrong device, preflight
    STOPPED = 4  # by a person or a signal
    FAILED = 5  # after the first voltage
    OUTPUT_UNKNOWN = 6  # the output is not known to be safe, whatever else happened


class RenamedKeyWarning(DeprecationWarning):
    """A key of a configuration file has a new name; the old one is read for one release."""


class LabrigWarning(UserWarning):
    """Something about data or a model that is no error; the text is a sentence for the user."""


class LabrigError(Exception):
    """An error for the user, with the exit code it ends the program with."""

    code = ExitCode.FAILED


class BadInputError(LabrigError):
    """An argument or a file's content is wrong."""

    code = ExitCode.BAD_INPUT


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
