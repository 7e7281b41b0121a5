"""A named effect in each configuration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.families import families, joined
from model.discrepancy.criticism.group_amplitudes import Group
from model.discrepancy.criticism.kinds._structure import contradicted, has_one_weight
from model.discrepancy.criticism.named_model import NamedModel
from model.effects.interface import Effect


@dataclass(frozen=True)
class ConfigurationStructure(VerdictCheck):
    """What is not a matter of each sheet is the same with all of them."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        every = families(named.fitted, named.outcome.outliers)
        groups = [
            Group(f"in '{name}'", joined([f for f in every if f.configuration == name]))
            for name in named.fitted.problem.forward.names
        ]
        yield from contradicted(named, groups, _shared)


def _shared(effect: Effect) -> bool:
    return has_one_weight(effect) and not effect.by_configuration


CHECK = ConfigurationStructure(
    name="configuration_structure",
    meaning="each named effect acts alike in all configurations, where it is not of each its own",
    order=41,
)
