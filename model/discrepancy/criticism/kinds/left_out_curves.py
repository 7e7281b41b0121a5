"""Neutral curves at positions that are left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.kinds._residuals import too_large
from model.discrepancy.criticism.named_model import NamedModel


@dataclass(frozen=True)
class LeftOutCurves(VerdictCheck):
    """Of all configurations and voltages together."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        yield from too_large(named, lambda f: f.quantity, lambda f: f.quantity == "neutral curve")


CHECK = LeftOutCurves(
    name="left_out_curves",
    meaning="neutral curves at left-out positions are predicted within noise and usual scatter",
    order=11,
)
