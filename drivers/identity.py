"""What a device reports of itself, asked in a way that can cost no run."""

from __future__ import annotations

from drivers.interfaces import DeviceIdentity, Identified


def identities_of(device: object) -> tuple[DeviceIdentity, ...]:
    """Return what an open device reports; nothing where it reports nothing, or fails to."""
    if not isinstance(device, Identified):
        return ()
    try:
        found = tuple(device.identities())
    except (Exception, SystemExit):  # noqa: BLE001 - who a device is must never keep it from being used
        return ()
    return tuple(each for each in found if isinstance(each, DeviceIdentity))


def says_simulated(text: str) -> bool | None:
    """Return True where a device calls itself simulated; None: what else it says proves nothing."""
    return True if "simulated" in text.lower() else None
