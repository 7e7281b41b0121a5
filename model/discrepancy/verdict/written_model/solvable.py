"""Whether a model that is to be written has an answer all over what its session spans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from model.identification.data.data_vector import DataVector
from model.identification.likelihood.forward_model import ForwardModel
from model.measurements import ModelError
from model.sheet.sheet_model import SheetModel
from model.sheet.solution import all_solved

HALF = 0.5  # of the voltages of a session
Place = tuple[float, float]  # position in m, voltage


def unsolved_at(model: SheetModel, forward: ForwardModel) -> str:
    """Return the first place, in words, at which a model has no solution; empty: there is none.

    Asked for are half the session's voltages at the outer positions and half-way between all of
    them, in each session: what was measured itself is asked for by `stated_errors`. What is not
    reachable without the model's effects does not count.
    """
    for name, data_vector in zip(forward.names, forward.data_vectors, strict=True):
        places = list(dict.fromkeys(_places(data_vector)))
        for number in sorted({one.session for one in data_vector.seen}):
            found = _first_unsolved(model.in_session(number), name, places)
            if found is not None:
                return f"{name}, {found[0] * 1e3:.3g} mm, {found[1]:+.3g} V"
    return ""


def _places(data_vector: DataVector) -> Iterator[Place]:
    """Yield positions and voltages within what was measured."""
    touching = [one for one in data_vector.seen if not (one.free or one.zero or one.tilt_rad)]
    positions = sorted({float(one.position_m) for one in touching})
    between = [0.5 * (a + b) for a, b in pairwise(positions)]
    voltages = sorted({HALF * float(one.voltage_V) for one in touching})
    for at_m in sorted({*positions[:1], *between, *positions[-1:]}):
        for volts in voltages:
            yield at_m, volts


def _first_unsolved(model: SheetModel, name: str, places: list[Place]) -> Place | None:
    """Return the first of some places of a configuration that has no solution with the effects."""
    if not places:
        return None
    if _all_solved(model, name, places):
        return None
    plain = replace(model, effects=())
    for place in places:
        if not _all_solved(model, name, [place]) and _all_solved(plain, name, [place]):
            return place
    return None


def _all_solved(model: SheetModel, name: str, places: list[Place]) -> bool:
    every = list(
        dict.fromkeys(
            (at, v) for at, volts in places for v in model.alternating_voltages_V(name, volts)
        )
    )
    try:
        return all_solved(model.setups(name, every))
    except ModelError:  # the effects do not settle
        return False
