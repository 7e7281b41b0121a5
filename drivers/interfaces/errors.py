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
