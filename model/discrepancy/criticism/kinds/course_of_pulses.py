"""How the force changes within a pulse."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.kinds._residuals import too_large
from model.discrepancy.criticism.named_model import NamedModel


@dataclass(frozen=True)
class CourseOfPulses(VerdictCheck):
    """Parts of a pulse less its sampling point."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        yield from too_large(
            named, lambda f: f.quantity, lambda f: f.quantity == "course of a pulse"
        )


CHECK = CourseOfPulses(
    name="course_of_pulses",
    meaning="the force changes within a pulse as predicted",
    order=13,
)
