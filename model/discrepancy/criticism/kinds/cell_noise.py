"""Noise of the load cell that is larger than usual beside a name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.cell_noise import CELL
from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import MOUNTING, NamedModel
from model.discrepancy.thresholds import ALARMING_SCATTER_RATIO


@dataclass(frozen=True)
class LoadCellNoise(VerdictCheck):
    """A force that goes with the place and has no name hides in the noise of the load cell.

    What has an order is something unknown beside the names, which are then judged with it; noise
    without an order speaks against none of them. The zero without an order is the matter of
    `scatter`.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        found = named.cell_noise
        if found is None:
            return
        text = f"beside the names the {CELL[found.name]} is {found.times:.0f} times the usual one"
        if found.term is not None:
            order = "what it takes up is smooth or comes back, as noise does not"
            yield Failure(consequence=Consequence.REMARK, sentence=f"{text}, and {order}")
        elif found.times > ALARMING_SCATTER_RATIO and found.name not in MOUNTING:
            yield Failure(
                consequence=Consequence.REMARK, sentence=f"{text}, without any order in it"
            )


CHECK = LoadCellNoise(
    name="cell_noise",
    meaning="beside the names the load cell is no noisier than is usual",
    order=21,
)
