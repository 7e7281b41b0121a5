"""Left-out positions of each configuration by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.families import MEANS
from model.discrepancy.criticism.kinds._residuals import too_large
from model.discrepancy.criticism.named_model import NamedModel


@dataclass(frozen=True)
class EachConfiguration(VerdictCheck):
    """Mean forces and curves."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        yield from too_large(named, lambda f: f"'{f.configuration}'", lambda f: f.quantity in MEANS)


CHECK = EachConfiguration(
    name="each_configuration",
    meaning="each configuration by itself agrees with the prediction",
    order=15,
)
