"""Make a family of the class of a simple board."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from drivers.boards.contract import BoardFamily
from drivers.boards.simple.board import SimpleBoard, SimpleSettings
from drivers.boards.simple.connection import SimpleConnection, inputs_of
from drivers.boards.simple.rescue import SimpleRescue
from drivers.interfaces import Clock, DeviceError


def simple_family(
    *,
    kind: str,
    help: str,  # noqa: A002 - as the contract has it
    settings: type,
    board: Callable[[Any], SimpleBoard],
    simulated: Callable[[Any, Any], SimpleBoard] | None = None,
) -> BoardFamily:
    """Return a family: `settings` is a subclass of `SimpleSettings`, `board` is made of them.

    `simulated` makes a board of the settings and the transport of a simulated family
    (`labrig.simulated_families`). Without it no simulated rig is wired with these boards: their
    code would reach the real ones.
    """

    def connect(found: SimpleSettings, clock: Clock, transport: object) -> SimpleConnection:
        if transport is None:
            return SimpleConnection(kind, board(found), found, clock)
        if simulated is None:
            raise DeviceError(
                f'[{kind}] address = "simulated": the driver of these boards cannot be simulated; '
                "its simple_family needs `simulated`, or state the address of boards"
            )
        return SimpleConnection(kind, simulated(found, transport), found, clock)

    def rescue(place: Mapping[str, Any], clock: Clock) -> SimpleRescue:
        try:
            found, safe_below_V = settings(**place["settings"]), float(place["safe_below_V"])
        except (KeyError, TypeError, ValueError) as fault:
            raise DeviceError(f"the place of the output cannot be read: {fault}") from fault
        return SimpleRescue(connect(found, clock, None), found, safe_below_V, clock)

    return BoardFamily(
        kind=kind,
        help=help,
        settings=settings,
        connect=connect,
        inputs=inputs_of,
        output_place=_output_place,
        rescue=rescue,
        can_be_simulated=simulated is not None,
    )


def _output_place(
    settings: SimpleSettings, limit_V: float, safe_below_V: float, line: str | None
) -> dict[str, Any]:
    del limit_V, line  # 0 V is all that a rescue writes; there is no line
    return {"settings": asdict(settings), "safe_below_V": safe_below_V}
