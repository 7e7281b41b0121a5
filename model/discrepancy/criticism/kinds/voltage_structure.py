"""A named effect at each voltage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.families import families, joined
from model.discrepancy.criticism.group_amplitudes import Group
from model.discrepancy.criticism.kinds._structure import contradicted
from model.discrepancy.criticism.named_model import NamedModel
from model.effects.interface import Effect
from model.measurements import in_volts


@dataclass(frozen=True)
class VoltageStructure(VerdictCheck):
    """An effect that is at one voltage what it is at another, but for the tolerance of its form.

    What friction and play do at 0 V is a matter of how the sheet came there, not of the effect. So
    is what sticks at either polarity: a slip lets go of any part of it.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        every = families(named.fitted, named.outcome.outliers)
        groups = {
            v: Group(f"at {in_volts(v)}", joined([f for f in every if f.voltage_V == v]))
            for v in sorted({f.voltage_V for f in every})
        }
        driven = [group for v, group in groups.items() if v]
        yield from contradicted(
            named, list(groups.values()), lambda one: not one.by_history, along="voltage"
        )
        yield from contradicted(named, driven, _held_alike, along="voltage")


def _held_alike(effect: Effect) -> bool:
    return effect.by_history and "polarity" not in effect.form_error_along


CHECK = VoltageStructure(
    name="voltage_structure",
    meaning="each named effect acts alike at all voltages",
    order=40,
)
