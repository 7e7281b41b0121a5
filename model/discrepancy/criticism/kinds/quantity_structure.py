"""A named effect in forces, in curves and in their course in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.families import MEANS, families, joined
from model.discrepancy.criticism.group_amplitudes import Group
from model.discrepancy.criticism.kinds._structure import contradicted, has_one_weight
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.search.form_share import in_time


@dataclass(frozen=True)
class QuantityStructure(VerdictCheck):
    """What explains the means explains what they imply: the shape, and the course in time.

    A drift that is inferred from means must be seen to grow along each run.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        every = families(named.fitted, named.outcome.outliers)
        groups = {
            name: Group(f"in the {name}", joined([f for f in every if f.quantity == name]))
            for name in dict.fromkeys(f.quantity for f in every)
        }
        means = [group for name, group in groups.items() if name in MEANS]
        yield from contradicted(named, means, lambda one: has_one_weight(one) and not in_time(one))
        yield from contradicted(named, list(groups.values()), in_time)


CHECK = QuantityStructure(
    name="quantity_structure",
    meaning="each named effect is the same in forces, curves and their course in time",
    order=43,
)
