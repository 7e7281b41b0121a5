"""Models of sheets whose numbers are stated rather than fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model.measurements import FloatArray, ModelError, SheetGeometry
from model.parameter import Parameter
from model.sheet.configured_sheet import Along, ConfiguredSheet
from model.sheet.sheet_model import SheetModel

SOFTEST_PA, STIFFEST_PA = 1.0, 2e12  # no solid has an equivalent Young modulus beyond these
SOFT_PA, STIFF_PA = 1e6, 1e11  # from rubber to metal: what may have been meant
MOST_TURNS = 10.0  # of a sheet without load; the paper's makes a quarter of one

# Me in N m: one number, or (s_m, Me_Nm) with straight lines between the nodes
StatedEibm = float | tuple[FloatArray, FloatArray]


def stated_model(
    sheet: SheetGeometry, B_Nm2: float, eibm_Nm: Mapping[float, StatedEibm]
) -> SheetModel:
    """Return the model of one sheet, its numbers taken as exact.

    A sheet whose initial curvature is not stated is taken as straight. Raises ModelError.
    """
    if not (np.isfinite(B_Nm2) and B_Nm2 > 0.0):
        raise ModelError(f"B = {B_Nm2:g} N m²: the bending stiffness must be positive")
    _refuse_no_solid(sheet, B_Nm2)
    nodes, k0 = sheet.initial_curvature or (np.zeros(1), np.zeros(1))
    geometry = replace(sheet, initial_curvature=(nodes, k0))
    rest = Along(nodes, k0, np.zeros(len(nodes)), "1/m")
    one = ConfiguredSheet(geometry, Parameter(value=B_Nm2, sigma=0.0, unit="N m^2"), rest, {})
    model = SheetModel(sheets={sheet.configuration: one})
    return with_eibm(model, eibm_Nm)


def with_eibm(model: SheetModel, eibm_Nm: Mapping[float, StatedEibm]) -> SheetModel:
    """Return a model whose EIBM at some voltages is as stated, in every configuration.

    What the model's effects change comes on top. Its errors against data are forgotten, since it
    describes others. Raises ModelError.
    """
    if not eibm_Nm:
        return model
    stated = {_voltage(volts): _along(volts, values) for volts, values in eibm_Nm.items()}
    for one in model.sheets.values():
        for volts, along in stated.items():
            _refuse_wound_up(one, volts, along)
    sheets = {name: replace(one, eibm={**one.eibm, **stated}) for name, one in model.sheets.items()}
    return replace(model, sheets=sheets, merit={}, own_merit={}, dynamic={}, deviations={})


def _refuse_no_solid(sheet: SheetGeometry, B_Nm2: float) -> None:
    """Raise ModelError for a bending stiffness that no sheet of this width and thickness has."""
    area_moment_m4 = sheet.width_m * sheet.thickness_m**3 / 12.0
    modulus_Pa = B_Nm2 / area_moment_m4
    if SOFTEST_PA <= modulus_Pa <= STIFFEST_PA:
        return
    check = "check width and thickness, too"
    if SOFT_PA <= 1e-6 * modulus_Pa <= STIFF_PA:
        check = f"{B_Nm2:g} µN m² are {1e-6 * B_Nm2:g} N m²"
    raise ModelError(
        f"B = {B_Nm2:g} N m² of '{sheet.configuration}' means a Young modulus of"
        f" {modulus_Pa:.3g} Pa, which no solid has; {check}"
    )


def _refuse_wound_up(one: ConfiguredSheet, voltage_V: float, along: Along) -> None:
    """Raise ModelError for an EIBM that nobody can mean; solving for it takes hours."""
    largest_Nm = float(np.max(np.abs(along.values)))
    turns = largest_Nm / one.B.value * one.sheet.free_length_m / (2.0 * np.pi)
    if turns > MOST_TURNS:
        raise ModelError(
            f"the EIBM stated at {voltage_V:+g} V would wind '{one.sheet.configuration}' up"
            f" {turns:.3g} times: {largest_Nm:g} N m with B = {one.B.value:g} N m²; one of a"
            " sheet is some 1e-5 N m"
        )


def _voltage(voltage_V: float) -> float:
    if not (np.isfinite(voltage_V) and voltage_V):
        raise ModelError(f"an EIBM at {voltage_V:g} V cannot be stated: at 0 V there is none")
    return float(voltage_V)


def _along(voltage_V: float, values: StatedEibm) -> Along:
    where = f"the EIBM stated at {voltage_V:+g} V"
    if isinstance(values, tuple):
        s_m, Me_Nm = (np.asarray(part, dtype=np.float64) for part in values)
    else:
        s_m, Me_Nm = np.zeros(1), np.array([values], dtype=np.float64)
    if s_m.shape != Me_Nm.shape or s_m.ndim != 1 or not len(s_m):
        raise ModelError(f"{where} needs as many places as values, in one row each")
    if not (np.isfinite(s_m).all() and np.isfinite(Me_Nm).all()):
        raise ModelError(f"{where} must be finite numbers")
    if np.any(np.diff(s_m) <= 0.0):
        raise ModelError(f"the places of {where} must rise from one to the next")
    return Along(s_m, Me_Nm, np.zeros(len(s_m)), "N m")
