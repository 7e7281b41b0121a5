"""Set-ups that differ by far more than usual beside a name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import MOUNTING, NamedModel
from model.discrepancy.thresholds import ALARMING_SCATTER_RATIO


@dataclass(frozen=True)
class Scatter(VerdictCheck):
    """What acts differently in each set-up and has no name hides in the scatter."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        for name, title in MOUNTING.items():
            ratio = named.scatter_ratio.get(name, 0.0)
            if ratio > ALARMING_SCATTER_RATIO:
                yield Failure(
                    consequence=Consequence.REJECT,
                    sentence=(
                        f"beside the name {title} still differs from set-up to set-up"
                        f" {ratio:.0f} times as much as usual"
                    ),
                )


CHECK = Scatter(
    name="scatter",
    meaning="with the named effects set-ups differ by no more than is usual",
    order=20,
)
