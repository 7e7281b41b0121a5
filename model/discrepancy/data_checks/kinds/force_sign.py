"""The sign of the forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import Change, DataCheck, Suspicion
from model.discrepancy.data_checks.kinds._data import quoted, with_forces
from model.discrepancy.data_checks.shape_compliance import shape_compliance
from model.discrepancy.thresholds import SURE_COMPLIANCE_SIGMA
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

    def of_failed_fit(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.of_failed_fit`: B by the curves alone would be negative."""
        for name in measurements.sheets:
            found = shape_compliance(measurements, name)
            if found is None or found.sigmas > -SURE_COMPLIANCE_SIGMA:
                continue
            yield Suspicion(
                check=self.name, severity="stop", where="force_mN", configurations=(name,),
                value=-1.0,
                sentence=(
                    f"the forces of {quoted([name])} (force_mN) have the opposite sign of what the"
                    " curves say, so B would be negative; check the load cell's sign"
                ),
            )  # fmt: skip


CHECK = ForceSign(name="force_sign", meaning="the sign of the forces against the curves", order=40)
