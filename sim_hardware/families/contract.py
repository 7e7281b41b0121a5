"""A simulated family of boards: how it is wired to a world, reached, and made to fail.

A module of this folder, or a distribution with an entry point of the group
`labrig.simulated_families`, adds one by the constant `FAMILY`. Its name is that of the family whose
driver reaches it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from drivers.interfaces import Clock
from sim_hardware.plugins import PluginFolder
from sim_hardware.world import World

Switch = tuple[Callable[[], None], Callable[[], None]]  # how a fault begins, and how it ends


class SimulatedBoards(Protocol):
    """The boards of one rig."""

    def transport(self) -> Any:
        """Return what the family's driver reaches them through in this process; not None.

        `connect` of the family is given it. It uses the world's clock, which is a virtual one.
        """

    def listen(self, port: int) -> int:
        """Answer on a port of this computer (0: a free one) and return it. PortTakenError.

        WorldError where these boards are simulated within labrig only.
        """

    def stop(self) -> None:
        """Listen no more. May be called twice."""

    def fault(self, what: str, amount_s: float) -> Switch:
        """Return the switch of a fault of `[[faults]]` that concerns boards. WorldError."""


@dataclass(frozen=True, kw_only=True)
class BoardOptions:
    """What the command line may say of the boards; a family takes what concerns it."""

    devices: Mapping[str, str] = field(default_factory=dict)  # name: product type
    driver_version: str = "26.0"
    strict_ownership: bool = False


@dataclass(frozen=True, kw_only=True)
class SimulatedFamily:
    """One family."""

    kind: str
    served_as: str  # the name of its address in what `serve` prints
    # Make the boards of a world. WorldError where the world's boards are none of this family.
    make: Callable[[World, Clock, BoardOptions], SimulatedBoards]


def switch_of(of: object, name: str, *, on: object, off: object) -> Switch:
    """Return the switch that sets an attribute; of a set or a dict, only what `on` holds."""
    if isinstance(on, set):
        return (
            lambda: setattr(of, name, getattr(of, name) | on),
            lambda: setattr(of, name, getattr(of, name) - on),
        )
    if isinstance(on, dict):
        return (
            lambda: setattr(of, name, getattr(of, name) | on),
            lambda: setattr(of, name, _without(getattr(of, name), on)),
        )
    return lambda: setattr(of, name, on), lambda: setattr(of, name, off)


def _without(these: dict[str, object], those: dict[str, object]) -> dict[str, object]:
    return {name: value for name, value in these.items() if name not in those}


def faults(part: object) -> list[str]:
    """Return what is wrong with a family, a sentence each."""
    return list(_faults(part))


def _faults(part: object) -> Iterator[str]:
    if not isinstance(part, SimulatedFamily):
        yield f"it is of type {type(part).__name__}, not a SimulatedFamily"
        return
    if not part.kind.isidentifier() or not part.served_as.isidentifier():
        yield "kind and served_as must be names"
    make: object = part.make
    if not callable(make):
        yield "its make cannot be called"


FOLDER: PluginFolder[SimulatedFamily] = PluginFolder(
    what="simulated family of boards",
    package="sim_hardware.families",
    constant="FAMILY",
    group="labrig.simulated_families",
    faults=faults,
)
