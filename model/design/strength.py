"""Force over width of a sheet cut to another size, and the sizes among which one is searched."""

from __future__ import annotations

from typing import Literal

import numpy as np

from model.design.force_map import force_map, known_voltages, resized
from model.design.propagation import propagate
from model.design.working_section import LONGER
from model.measurements import FloatArray
from model.sheet.sheet_model import SheetModel

Direction = Literal["both", "positive", "negative"]

# in radii of the arc
SHORTEST_R = 0.05  # of a sheet with an elongation; the longest reaches the object by itself
LONGEST_R = 1.8  # of a sheet without one, unless more is needed to reach
ELONGATION_R = 1.5  # reaches the object everywhere
_NOWHERE_R = 1e3  # stands for a length that does not exist

_MARGIN_SIGMA = 3.0  # a sheet without elongation reaches also where the parameters are a bit off


def strength(
    model: SheetModel,
    configuration: str,
    length_m: float,
    elongation_m: float,
    position_m: FloatArray,
    direction: Direction,
) -> FloatArray:
    """Return the force over width that is possible at each position, N/m; 0: not reachable."""
    changed = resized(model, configuration, length_m, elongation_m)
    found = force_map(changed, configuration, position_m, known_voltages(model, configuration))
    up, down = found.tangential_N.max(axis=1), -found.tangential_N.min(axis=1)
    choice = {"both": np.minimum(up, down), "positive": up, "negative": down}
    per_width = choice[direction] / model.sheet(configuration).sheet.width_m
    return np.where(found.reachable.all(axis=1), per_width, 0.0)


def elongated_lengths_m(model: SheetModel, configuration: str, count: int) -> FloatArray:
    """Return free lengths to be tried with an elongation."""
    R = model.sheet(configuration).sheet.arc_radius_m
    return np.linspace(SHORTEST_R * R, R, count)


def lengths_alone_m(
    model: SheetModel, configuration: str, shortest_m: float, count: int
) -> FloatArray:
    """Return lengths to be tried without an elongation, from the shortest that reaches on."""
    R = model.sheet(configuration).sheet.arc_radius_m
    return np.linspace(shortest_m, max(LONGEST_R * R, shortest_m), count)


def shortest_alone_m(model: SheetModel, configuration: str, position_m: FloatArray) -> FloatArray:
    """Return the length without elongation that reaches each position; inf: no length does.

    It reaches at all voltages of the model, with a margin for the uncertainty of its parameters.
    """
    nowhere_m = _NOWHERE_R * model.sheet(configuration).sheet.arc_radius_m
    lengths = np.full(len(position_m), np.inf)
    exact = _contacts_m(model, configuration, position_m, nowhere_m)
    reached = exact < nowhere_m
    if not reached.any():
        return lengths
    found = propagate(
        model, configuration,
        lambda changed: _contacts_m(
            changed, configuration, position_m[reached], nowhere_m
        ).tolist(),
        ["m"] * int(reached.sum()),
    )  # fmt: skip
    # one that is reached nowhere within the uncertainty has a huge one
    needed = np.array([one.value + _MARGIN_SIGMA * one.sigma for one in found])
    lengths[reached] = np.where(needed < nowhere_m, needed, np.inf)
    return lengths


def _contacts_m(
    model: SheetModel, configuration: str, position_m: FloatArray, nowhere_m: float
) -> FloatArray:
    """Return the farthest contact at each position, of the first of ever longer sheets.

    What lies beyond the contact changes nothing; but the longer the sheet is, the more it curls.
    """
    R, volts = nowhere_m / _NOWHERE_R, known_voltages(model, configuration)
    contacts = np.full(len(position_m), nowhere_m)
    for share in LONGER:
        left = np.flatnonzero(contacts == nowhere_m)
        if not len(left):
            break
        longer = resized(model, configuration, share * R, 0.0)
        found = force_map(longer, configuration, position_m[left], volts)
        inside = found.reachable.all(axis=1)
        contacts[left[inside]] = found.s_hat_m[inside].max(axis=1)
    return contacts
