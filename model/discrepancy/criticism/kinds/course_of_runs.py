"""How readings change along a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.kinds._residuals import too_large
from model.discrepancy.criticism.named_model import NamedModel


@dataclass(frozen=True)
class CourseOfRuns(VerdictCheck):
    """Trends and first pulses of forces and curves."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        yield from too_large(named, lambda f: f.quantity, lambda f: f.quantity == "course of a run")


CHECK = CourseOfRuns(
    name="course_of_runs",
    meaning="readings change along a run as predicted",
    order=12,
)
