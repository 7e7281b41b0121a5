"""What goes wrong with a device, by what the caller may do about it."""

from __future__ import annotations


class DeviceError(Exception):
    """A device did not do what was asked of it.

    The text is one sentence for the operator: which device, what was asked, what came instead, and
    what to do. Drivers raise subclasses of it and nothing else.
    """


class DeviceNotFoundError(DeviceError):
    """The device, its driver or its server is not there, or is of another type."""


class DeviceTimeoutError(DeviceError):
    """The device did not answer in the time that the request can take."""


class LimitError(DeviceError):
    """A value outside the configured limits was asked for; nothing was sent to the device."""


class OverloadError(DeviceError):
    """The load cell is loaded beyond what it stands."""


class OvervoltageError(DeviceError):
    """The sheet has a higher voltage than it may have."""


class LostSamplesError(DeviceError):
    """Samples were overwritten before they were read."""


# What Python raises where a program is wrong: the texts are for its author ("'volts'").
_OF_PROGRAMS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    NameError,
    NotImplementedError,
    SystemExit,  # the program is not a part's to end
    TypeError,
)


def is_mistake(fault: BaseException) -> bool:
    """Whether a program is wrong, by the type of its error: one of Python's own of that kind."""
    return isinstance(fault, _OF_PROGRAMS) and type(fault).__module__ == "builtins"


def behind(error: BaseException) -> BaseException:
    """Return the error of which a device's error was made."""
    while isinstance(error, DeviceError) and error.__cause__ is not None:
        error = error.__cause__
    return error


def in_words(fault: BaseException) -> str:
    """Return what an error says, on one line and without its full stop.

    Where the text is none, or for the author of a program, its type is told.
    """
    text, kind = " ".join(str(fault).split()).rstrip("."), type(fault).__name__
    if not text:
        return kind
    return f"{kind}: {text}" if is_mistake(fault) else text
