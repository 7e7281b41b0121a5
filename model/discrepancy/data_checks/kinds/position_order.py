"""The order and the direction of the positions on the arc."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import mm, positions_m, with_positions
from model.measurements import Measurements


@dataclass(frozen=True)
class PositionOrder(DataCheck):
    """The last one first, or counted the other way."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        places = positions_m(measurements)
        if len(places) < 2:
            return
        low, high = places[0], places[-1]
        yield Change(
            where="position_mm",
            apply=lambda m, _: with_positions(m, lambda p: low + high - p),
            sentence=lambda names, _value, _sigma: (
                f"the positions of {names} (position_mm) fit in reverse order, from"
                f" {mm(high)} to {mm(low)}"
            ),
            values=(1.0,),
        )
        yield Change(
            where="position_mm",
            apply=lambda m, _: with_positions(m, lambda p: -p),
            sentence=lambda names, _value, _sigma: (
                f"the positions of {names} (position_mm) fit with the other sign: they seem to be"
                " counted to the other side, or x and y of the curves are mirrored"
            ),
            values=(-1.0,),
        )


CHECK = PositionOrder(
    name="position_order",
    meaning="order and direction of the positions against forces and curves",
    order=20,
)
