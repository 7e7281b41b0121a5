"""Left-out positions at each voltage by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.families import MEANS
from model.discrepancy.criticism.kinds._residuals import too_large
from model.discrepancy.criticism.named_model import NamedModel
from model.measurements import in_volts


@dataclass(frozen=True)
class EachVoltage(VerdictCheck):
    """Mean forces and curves."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        yield from too_large(
            named, lambda f: f"at {in_volts(f.voltage_V)}", lambda f: f.quantity in MEANS
        )


CHECK = EachVoltage(
    name="each_voltage",
    meaning="each voltage by itself agrees with the prediction",
    order=14,
)
