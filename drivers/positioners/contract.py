"""A kind of positioner: its settings in [stage] of rig.toml, and how to make a `Positioner` of it.

A module of this folder, or a distribution with an entry point of the group `labrig.positioners`,
adds a kind by the constant `POSITIONER`. `drivers.interfaces.Positioner` says what it does when;
`positioner_faults` in `conformance` finds one that does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from drivers.interfaces import Clock, Operator, Positioner
from drivers.kinds import kind_faults
from drivers.plugins import PluginFolder

DEFAULT = "manual"  # the kind of a rig.toml that names none


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """What a positioner may use besides its settings."""

    clock: Clock
    operator: Operator  # answers questions; `ask` returns False when the session is to stop
    arc_radius_m: float
    # Opens the device's line instead of the vendor's library: the simulator's hook. It takes the
    # arguments of pyserial's `Serial` and has its interface. None: the real one.
    transport: Callable[..., Any] | None = None


@dataclass(frozen=True, kw_only=True)
class PositionerKind:
    """A kind of positioner. One with a device has a setting `port`."""

    kind: str
    help: str  # one line
    settings: type
    # Make a positioner, not open yet, from its settings. Touches no device.
    make: Callable[[Any, Surroundings], Positioner]


def faults(part: object) -> list[str]:
    """Return what is wrong with a kind of positioner, a sentence each."""
    return list(kind_faults(part, PositionerKind, {"make": ("settings", "surroundings")}))


POSITIONERS: PluginFolder[PositionerKind] = PluginFolder(
    what="positioner",
    package="drivers.positioners",
    constant="POSITIONER",
    group="labrig.positioners",
    faults=faults,
)
