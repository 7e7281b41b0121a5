"""Check a simulated board against the contract."""

from __future__ import annotations

import re
from collections.abc import Iterator

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import (
    AnalogInputs,
    AnalogOutputs,
    BoardModel,
    DigitalPort,
    Terminals,
)

_PRODUCT_TYPE = re.compile(r"^[A-Za-z0-9][A-Za-z0-9 ()_.-]*$")
_MOST_CHANNELS = 1000
_RESOLUTIONS = range(8, 17)  # samples travel as 16 bit codes
_MOST_LINES = 32  # a port is read as one 32 bit word


def faults(part: object) -> list[str]:
    """Return what is wrong with a board, a sentence each; empty where it can be simulated."""
    if not isinstance(part, BoardModel):
        return [f"BOARD is of the type {type(part).__name__}, not a BoardModel"]
    return list(_of_board(part))


def _of_board(board: BoardModel) -> Iterator[str]:
    if not _PRODUCT_TYPE.match(board.product_type):
        yield f"product_type = {board.product_type!r} must be a name such as USB-6211"
    if board.product_number is not None and not 0 <= board.product_number < 2**32:
        yield f"product_number = {board.product_number} must have 32 bits, or be None"
    if not isinstance(board.category, ProductCategory):
        yield f"category = {board.category!r} must be a nidaqmx.constants.ProductCategory"
    if not isinstance(board.bus, BusType):
        yield f"bus = {board.bus!r} must be a nidaqmx.constants.BusType"
    yield from _of_chassis(board)
    if board.analog_in is not None:
        yield from _of_inputs(board.analog_in)
    if board.analog_out is not None:
        yield from _of_outputs(board.analog_out)
    for number, port in enumerate(board.ports):
        yield from _of_port(number, port)


def _of_chassis(board: BoardModel) -> Iterator[str]:
    has_channels = bool(board.analog_in or board.analog_out or board.ports)
    if not has_channels and not board.slots:
        yield "it has neither inputs, outputs nor ports, and no slots for modules"
    if board.slots < 0 or (board.slots and (has_channels or board.in_chassis)):
        yield f"slots = {board.slots} must be 0 but of a chassis, which has no channels of its own"


def _of_inputs(side: AnalogInputs) -> Iterator[str]:
    yield from _of_side("analog_in", side)
    if len(side.noise_V) != len(side.ranges_V) or any(noise < 0 for noise in side.noise_V):
        yield "analog_in.noise_V must hold one value, 0 or more, for each range"
    if not 0 < side.min_rate_hz < side.max_rate_hz <= side.timebase_hz:
        yield "analog_in: 0 < min_rate_hz < max_rate_hz <= timebase_hz must hold"
    if not 0 < side.max_multi_rate_hz <= side.max_rate_hz:
        yield "analog_in.max_multi_rate_hz must be above 0 and at most max_rate_hz"
    if side.fifo_samples < 1 or side.settling_s < 0:
        yield "analog_in: fifo_samples must be at least 1 and settling_s at least 0"
    yield from _of_terminals(side)


def _of_terminals(side: AnalogInputs) -> Iterator[str]:
    known = [t for t in side.terminals if isinstance(t, Terminals) and t is not Terminals.DEFAULT]
    if not known or len(set(known)) != len(side.terminals):
        yield "analog_in.terminals must name each of DIFFERENTIAL, RSE, NRSE at most once"
    elif side.pair_offset < 0 or (side.pair_offset and known == [Terminals.DIFFERENTIAL]):
        yield "analog_in.pair_offset must be 0 where all inputs are differential, else at least 0"


def _of_outputs(side: AnalogOutputs) -> Iterator[str]:
    yield from _of_side("analog_out", side)
    if side.clocked != (side.max_rate_hz is not None and side.max_rate_hz > 0):
        yield "analog_out.max_rate_hz must be above 0 where clocked, else None"


def _of_side(name: str, side: AnalogInputs | AnalogOutputs) -> Iterator[str]:
    if not 1 <= side.channels <= _MOST_CHANNELS:
        yield f"{name}.channels = {side.channels} must be 1 to {_MOST_CHANNELS}"
    rising = sorted(set(side.ranges_V)) == list(side.ranges_V)
    if not side.ranges_V or not rising or side.ranges_V[0] <= 0:
        yield f"{name}.ranges_V must be above 0, smallest first"
    if side.resolution_bits not in _RESOLUTIONS:
        yield (
            f"{name}.resolution_bits = {side.resolution_bits} must be {_RESOLUTIONS[0]} to "
            f"{_RESOLUTIONS[-1]}"
        )


def _of_port(number: int, port: DigitalPort) -> Iterator[str]:
    if not 1 <= port.lines <= _MOST_LINES:
        yield f"ports[{number}].lines = {port.lines} must be 1 to {_MOST_LINES}"
    if not (port.inputs or port.outputs):
        yield f"ports[{number}] has neither inputs nor outputs"
