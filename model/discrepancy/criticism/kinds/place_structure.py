"""A named effect along the arc."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.families import families, joined
from model.discrepancy.criticism.group_amplitudes import Group
from model.discrepancy.criticism.kinds._structure import contradicted
from model.discrepancy.criticism.named_model import NamedModel

PARTS = ("in the first third of the arc", "amid the arc", "in the last third of the arc")


@dataclass(frozen=True)
class PlaceStructure(VerdictCheck):
    """An effect that is in one part of the arc what it is in another."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        yield from contradicted(named, _thirds(named), along="position")


def _thirds(named: NamedModel) -> list[Group]:
    """Return the rows of the lowest, middle and highest third of the positions."""
    row_index = named.fitted.problem.forward.row_index
    rows = joined(families(named.fitted, named.outcome.outliers))
    position_m = np.array([run[1] for run in row_index.runs])[row_index.run_of[rows]]
    known = np.unique(position_m[np.isfinite(position_m)])
    if len(known) < len(PARTS):
        return []
    parts = np.array_split(known, len(PARTS))
    return [
        Group(title, rows[np.isin(position_m, part)])
        for title, part in zip(PARTS, parts, strict=True)
    ]


CHECK = PlaceStructure(
    name="place_structure",
    meaning="each named effect acts alike along the arc",
    order=42,
)
