"""A kind of force sensor: its settings in [force_sensor] of rig.toml, and how it is read.

Either the board reads it, on its input `force`, or a `ForceSensor` does by itself (a meter). A
module of this folder, or a distribution with an entry point of the group `labrig.force_sensors`,
adds a kind by the constant `FORCE_SENSOR`. `drivers.interfaces.ForceSensor` says what it does when;
`force_sensor_faults` in `conformance` finds one that does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from drivers.interfaces import Clock, ForceSensor
from drivers.kinds import kind_faults
from drivers.plugins import PluginFolder

DEFAULT = "load_cell"  # the kind of a rig.toml that names none

Transport = Callable[..., Any]  # as pyserial's `Serial`


@dataclass(frozen=True, kw_only=True)
class ForceSensorKind:
    """A kind of force sensor. One with a device has a setting `port`."""

    kind: str
    help: str  # one line
    settings: type
    # Make a sensor, not open yet, from its settings and a clock; `Transport` opens its line instead
    # of the vendor's library (the simulator's hook; None: the real one). Touches no device.
    # None: the board reads this sensor.
    make: Callable[[Any, Clock, Transport | None], ForceSensor] | None = None


def faults(part: object) -> list[str]:
    """Return what is wrong with a kind of force sensor, a sentence each."""
    calls = {"make": ("settings", "clock", "transport")}
    return list(kind_faults(part, ForceSensorKind, calls))


FORCE_SENSORS: PluginFolder[ForceSensorKind] = PluginFolder(
    what="force sensor",
    package="drivers.force_sensors",
    constant="FORCE_SENSOR",
    group="labrig.force_sensors",
    faults=faults,
)
