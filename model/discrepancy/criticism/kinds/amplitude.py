"""Amplitudes that would be seen with the naked eye."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.thresholds import LEAST_OVERLOOKED, OVERLOOKED_TOLD
from model.effects.interface import EffectParameter
from model.identification.likelihood.model_state import Found


@dataclass(frozen=True)
class Amplitude(VerdictCheck):
    """Each parameter against its instrument limit, where it has one, less its uncertainty.

    Some laboratories overlook much: a large amplitude makes a name less probable. Only what nobody
    can overlook rejects it.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        for one in named.found:
            for parameter in one.effect.parameters:
                value, overlooked = least_overlooked(one, parameter)
                if overlooked >= OVERLOOKED_TOLD:
                    continue
                impossible = overlooked < LEAST_OVERLOOKED
                share = "" if impossible else f" ({100.0 * overlooked:.0f} % overlook that)"
                yield Failure(
                    consequence=(
                        Consequence.REJECT if impossible else Consequence.IMPROBABLE_AMPLITUDE
                    ),
                    sentence=f"{parameter.beyond_limit(value)}{share}",
                    effects=(one.effect.name,),
                    overlooked=overlooked,
                )


def least_overlooked(one: Found, parameter: EffectParameter) -> tuple[float, float]:
    """Return the largest value, and how probably nobody noticed it, less its uncertainty."""
    value, chance = 0.0, 1.0
    for name, values in one.values.items():
        size = abs(values[parameter.name])
        unsure = one.sigma.get(name, {}).get(parameter.name, 0.0)
        here = parameter.overlooked(max(size - unsure, 0.0))
        if here < chance:
            value, chance = size, here
    return value, chance


CHECK = Amplitude(
    name="amplitude",
    meaning="each amplitude is one that people in a laboratory may overlook",
    order=30,
)
