"""Turn what NI's package raises into `DeviceError`s: which device, what was asked, what to do.

Codes are those of NI-DAQmx; a code that is not in the table keeps NI's own words.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from drivers.interfaces import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    LimitError,
    LostSamplesError,
)

NO_DRIVER = (
    "the NI-DAQmx driver is not installed on this computer: install it from ni.com, or set "
    "[ni] address in rig.toml to host:port of the computer that runs an NI gRPC Device Server"
)


class TaskGoneError(DeviceError):
    """The task was cleared from outside: by the output guard, `labrig safe` or a server restart."""


class DeviceReservedError(DeviceError):
    """Another task or program holds the device."""


# What NI's package makes of a reply with other values, lengths or fields than it can have.
_NONSENSE = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    MemoryError,
    TypeError,
    ValueError,
)


def _is_of_ni(fault: BaseException) -> bool:
    """Whether NI's package was at work when it was raised, and not only code of ours."""
    frames = traceback.walk_tb(fault.__traceback__)
    return any(str(f.f_globals.get("__name__")).split(".")[0] == "nidaqmx" for f, _ in frames)


@dataclass(frozen=True)
class _Meaning:
    family: type[DeviceError]
    text: str


_DEVICE_GONE = _Meaning(DeviceNotFoundError, "the device is there by name but does not answer")
_OVERWRITTEN = _Meaning(LostSamplesError, "samples were overwritten before they were read")
_MEANINGS = {
    -200220: _Meaning(DeviceNotFoundError, "there is no such device"),
    -200170: _Meaning(DeviceNotFoundError, "the device has no such channel"),
    -201003: _DEVICE_GONE,
    -200324: _DEVICE_GONE,
    -50103: _Meaning(
        DeviceReservedError,
        "it is in use by another task or program; end that, then `labrig safe` writes 0 V",
    ),
    -200088: _Meaning(
        TaskGoneError,
        "its task no longer exists: the output guard, `labrig safe` or a restart of the server "
        "has cleared it",
    ),
    -200089: _Meaning(DeviceReservedError, "this program already has a task of that name"),
    -200279: _OVERWRITTEN,
    -200278: _OVERWRITTEN,
    -200361: _Meaning(LostSamplesError, "the board's own memory overflowed"),
    -200284: _Meaning(DeviceTimeoutError, "the samples did not arrive in time"),
    -200561: _Meaning(LimitError, "the value is outside the channel's limits; nothing was written"),
    -200077: _Meaning(DeviceError, "the board cannot do that: a range, rate or wiring it lacks"),
    -200846: _Meaning(DeviceError, "the acquisition is not running"),
}


def daq_error(doing: str, code: int, message: str, devices: Sequence[str] | None) -> DeviceError:
    """Return the error for an NI-DAQmx status code. `devices`: those found, where known."""
    meaning = _MEANINGS.get(code)
    if meaning is None:
        words = " ".join(message.partition("Status Code")[0].split()) or "no description"
        return DeviceError(f"{doing} failed: {words} (NI-DAQmx {code})")
    text = f"{doing} failed: {meaning.text} (NI-DAQmx {code})"
    if meaning.family is DeviceNotFoundError and devices is not None:
        there = ", ".join(devices) or "none"
        text += f"; devices found: {there}; correct the name in rig.toml"
    return meaning.family(text)


def rpc_error(doing: str, where: str, code_name: str, description: str) -> DeviceError:
    """Return the error for a gRPC status (its name, such as UNAVAILABLE)."""
    if code_name == "UNAVAILABLE":
        return DeviceNotFoundError(
            f"{doing} failed: no connection to {where}; start the server there, and check the "
            "address, the network and the firewall"
        )
    if code_name == "DEADLINE_EXCEEDED":
        return DeviceTimeoutError(
            f"{doing} failed: {where} did not answer in the time this can take; check the network "
            "and that computer"
        )
    if code_name == "UNIMPLEMENTED":
        return DeviceError(f"{doing} failed: {where} does not offer this; upgrade that server")
    return DeviceError(f"{doing} failed: {where} says {code_name}: {description}")


@contextmanager
def ni_errors(
    doing: str, where: str, devices: Callable[[], Sequence[str] | None] = lambda: None
) -> Iterator[None]:
    """Raise the matching `DeviceError` for whatever NI's package raises inside.

    `doing` begins the sentence ("open PCI6703/ao0"); `where` names the server or driver; `devices`
    is asked for the names that exist when one was not found.
    """
    from nidaqmx import errors

    try:
        yield
    except (errors.DaqNotFoundError, errors.DaqNotSupportedError) as fault:
        raise DeviceNotFoundError(f"{doing} failed: {NO_DRIVER}") from fault
    except errors.DaqError as fault:
        code = int(fault.error_code)
        there = devices() if code in (-200220, -200170) else None
        raise daq_error(doing, code, str(fault), there) from fault
    except errors.RpcError as fault:
        name = getattr(fault.rpc_code, "name", str(fault.rpc_code))
        raise rpc_error(doing, where, name, str(fault.description)) from fault
    except errors.Error as fault:
        raise DeviceError(f"{doing} failed: {where}: {fault}") from fault
    except _NONSENSE as fault:
        if "closed channel" in str(fault):  # gRPC's way to say so
            raise DeviceError(f"{doing} failed: the connection to {where} is closed") from fault
        if not _is_of_ni(fault):
            raise
        raise DeviceError(
            f"{doing} failed: {where} gave an answer that makes no sense ({type(fault).__name__}: "
            f"{str(fault)[:200]}); restart it, and check that its version fits"
        ) from fault
