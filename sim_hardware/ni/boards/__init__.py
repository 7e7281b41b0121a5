"""Simulated NI boards: one file each, and those of other distributions."""

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


__all__ = ["FOLDER", "BoardModel", "board_model", "board_models", "faults"]
