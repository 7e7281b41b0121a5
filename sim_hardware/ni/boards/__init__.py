"""Simulated NI boards: one file each, and those of other distributions."""

from collections.abc import Iterable
from difflib import get_close_matches

from sim_hardware.ni.boards.conformance import faults
from sim_hardware.ni.boards.contract import BoardModel
from sim_hardware.plugins import PluginFolder, UnknownPartError

FOLDER: PluginFolder[BoardModel] = PluginFolder(
    what="simulated board",
    package="sim_hardware.ni.boards",
    constant="BOARD",
    group="labrig.simulated_boards",
    faults=faults,
)


def board_models() -> dict[str, BoardModel]:
    """Return all boards by product type; of two of one type the first."""
    models: dict[str, BoardModel] = {}
    for part in FOLDER.parts().values():
        models.setdefault(part.part.product_type, part.part)
    return models


def board_model(product_type: str) -> BoardModel:
    """Return the board of this product type; UnknownPartError lists those there are."""
    models = board_models()
    if product_type not in models:
        close = get_close_matches(product_type.upper(), list(models), n=1)
        hint = f" (did you mean '{close[0]}'?)" if close else ""
        raise UnknownPartError(
            f"there is no simulated board '{product_type}'; choose one of: "
            f"{', '.join(sorted(models))}{hint}"
        )
    return models[product_type]


def output_board() -> str:
    """Return the product type of a board that has analog outputs alone."""
    return next(
        name
        for name, b in board_models().items()
        if b.analog_out and not b.analog_in and not b.in_chassis
    )


def input_board(ranges_V: Iterable[tuple[float, float]], *, outputs: bool) -> str:
    """Return the product type of a board with inputs, and with outputs or without.

    `ranges_V` are pairs: a range asked for, and the one that the board took. Where no board takes
    all of them, it is the first with the finest resolution.
    """

    def fit(board: BoardModel) -> tuple[bool, int]:
        side = board.analog_in
        if side is None:
            return False, 0
        return all(side.range_for(-ask, ask) == took for ask, took in pairs), side.resolution_bits

    pairs = tuple(ranges_V)
    able = [
        b
        for b in board_models().values()
        if b.analog_in and bool(b.analog_out) is outputs and not b.in_chassis
    ]
    return max(able, key=fit).product_type


__all__ = [
    "FOLDER",
    "BoardModel",
    "board_model",
    "board_models",
    "faults",
    "input_board",
    "output_board",
]
