"""The sign of the forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import with_forces
from model.measurements import Measurements


@dataclass(frozen=True)
class ForceSign(DataCheck):
    """Pull is push."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:  # noqa: ARG002 - for any
        """See `DataCheck.changes`."""
        yield Change(
            where="force_mN",
            apply=lambda m, value: with_forces(m, lambda force_N: value * force_N),
            sentence=lambda names, _value, _sigma: (
                f"the forces of {names} (force_mN) contradict the curves unless they have the other"
                " sign"
            ),
            values=(-1.0,),
        )


CHECK = ForceSign(name="force_sign", meaning="the sign of the forces against the curves", order=40)
