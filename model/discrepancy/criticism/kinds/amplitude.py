"""Amplitudes that would be seen with the naked eye."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel


@dataclass(frozen=True)
class Amplitude(VerdictCheck):
    """Each parameter against its instrument limit, where it has one, less its uncertainty."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        for one in named.found:
            for parameter in one.effect.parameters:
                limit = parameter.instrument_limit
                if limit is None:
                    continue
                for name, values in one.values.items():
                    value = abs(values[parameter.name])
                    unsure = one.sigma.get(name, {}).get(parameter.name, 0.0)
                    if value - unsure > limit:
                        sentence = parameter.beyond_limit(value)
                        yield Failure(
                            consequence="unknown", sentence=sentence, effects=(one.effect.name,)
                        )
                        break


CHECK = Amplitude(
    name="amplitude",
    meaning="each amplitude is one that nobody in the laboratory would have noticed",
    order=30,
)
