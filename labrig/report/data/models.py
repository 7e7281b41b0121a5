"""The two simulations that the paper compares, and what they say of measured conditions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model import Prediction, SheetModel, predict
from model.measurements import FloatArray
from model.sheet.solution import solved

# the names of the two simulations
ALONG, CONSTANT = "EIBM along the sheet", "constant EIBM"
# what was fitted for each, for notes below tables and figures
HELD = (
    "EIBM along the sheet: B and EIBM from the joint fit. Constant EIBM: B held at the value of"
    " that fit, EIBM held at its mean (9); nothing refitted."
)


@dataclass(frozen=True)
class Models:
    """Fitted to the same measurements."""

    along: SheetModel  # EIBM along the sheet, (8)
    constant: SheetModel  # one EIBM for each voltage, (9)

    def named(self) -> list[tuple[str, SheetModel]]:
        """Both, in the paper's order."""
        return [(ALONG, self.along), (CONSTANT, self.constant)]


def kind_of(model: SheetModel) -> str:
    """Return which of the two simulations a model makes."""
    fields = [along for one in model.sheets.values() for along in one.eibm.values()]
    changed = bool(model.effects or model.deviations)
    is_constant = not changed and all(np.ptp(along.values) == 0.0 for along in fields)
    return CONSTANT if is_constant else ALONG


def knows(model: SheetModel, configuration: str, voltage_V: float) -> bool:
    """Whether the model says anything about a configuration at a voltage."""
    sheet = model.sheets.get(configuration)
    if sheet is None:
        return False
    volts = [0.0, *sheet.eibm]
    return min(volts) <= voltage_V <= max(volts)


def predicted(
    model: SheetModel, configuration: str, position_m: float, voltage_V: float
) -> Prediction | None:
    """Return what the model says; None where it says nothing or the position cannot be reached."""
    if not knows(model, configuration, voltage_V):
        return None
    found = predict(model, configuration, position_m, voltage_V)
    return found if found.reachable else None


def force_curve_N(
    model: SheetModel, configuration: str, positions_m: FloatArray, voltage_V: float
) -> FloatArray:
    """F over positions, shape (positions,); NaN where a position cannot be reached."""
    volts = (
        model.alternating_voltages_V(configuration, voltage_V) if model.effects else (voltage_V,)
    )
    places = [(float(p), v) for v in volts for p in positions_m]
    # one batch: hundreds of points in the time of one `predict`
    return solved(model.setups(configuration, places)).force_N[: len(positions_m)]
