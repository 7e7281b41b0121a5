"""Amplitudes of opposite sign in two configurations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.thresholds import STRUCTURE_SIGMA
from model.effects import title


@dataclass(frozen=True)
class Signs(VerdictCheck):
    """What has one direction in the rig has it with every sheet."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        for one in named.found:
            parameter = one.effect.amplitude
            if not parameter.one_sign:
                continue
            low, high = [], []
            for name, values in one.values.items():
                reach = STRUCTURE_SIGMA * one.sigma.get(name, {}).get(parameter.name, 0.0)
                low += [name] if values[parameter.name] + reach < 0.0 else []
                high += [name] if values[parameter.name] - reach > 0.0 else []
            if low and high:
                yield Failure(
                    consequence=Consequence.REJECT,
                    sentence=(
                        f"{title(one.effect.name)} is positive in '{high[0]}' and negative in"
                        f" '{low[0]}', but it can only act one way"
                    ),
                    effects=(one.effect.name,),
                )


CHECK = Signs(
    name="signs",
    meaning="what can only act one way has the same sign in all configurations",
    order=31,
)
