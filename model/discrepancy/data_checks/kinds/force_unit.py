"""The unit of the forces, by their size and by the modulus that the curves ask for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.discrepancy.data_checks.kinds._data import quoted
from model.discrepancy.data_checks.shape_compliance import shape_compliance
from model.discrepancy.thresholds import (
    LARGEST_FORCE_N,
    SMALLEST_FORCE_N,
    SOFTEST_MODULUS_PA,
    STIFFEST_BY_CURVES_PA,
    STIFFEST_METAL_PA,
    SURE_COMPLIANCE_SIGMA,
)
from model.measurements import Measurements, SheetGeometry, in_digits

METAL = "; where the strip is of metal they may be right"
UNITS = {1e3: "N", 1e-3: "µN, or in mN and taken for N"}


@dataclass(frozen=True)
class ForceUnit(DataCheck):
    """Newtons among millinewtons.

    Where only the modulus is odd, width or thickness may be wrong; that is the material's check.
    """

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        for name, sheet in measurements.sheets.items():
            largest_N = _largest_N(measurements, name)
            if not largest_N or SMALLEST_FORCE_N < largest_N < LARGEST_FORCE_N:
                continue
            modulus_Pa = _modulus_Pa(measurements, sheet)
            if modulus_Pa is None or SOFTEST_MODULUS_PA < modulus_Pa < STIFFEST_BY_CURVES_PA:
                continue
            factor = 1e3 if largest_N <= SMALLEST_FORCE_N else 1e-3
            if SOFTEST_MODULUS_PA < factor * modulus_Pa < STIFFEST_BY_CURVES_PA:
                yield self._suspicion(name, largest_N, modulus_Pa, factor)

    def _suspicion(
        self, name: str, largest_N: float, modulus_Pa: float, factor: float
    ) -> Suspicion:
        return Suspicion(
            check=self.name, severity="stop", where="force_mN", configurations=(name,),
            value=factor,
            sentence=(
                f"the forces of {quoted([name])} (force_mN) are {in_digits(1e3 * largest_N, 3)} mN"
                f" at most, and by the curves Young's modulus would be {modulus_Pa:.1e} Pa;"
                f" multiplied by {factor:g} they fit, so they seem to be in {UNITS[factor]}"
                f"{METAL if factor < 1.0 and modulus_Pa < STIFFEST_METAL_PA else ''}"
            ),
        )  # fmt: skip


def _largest_N(measurements: Measurements, name: str) -> float:
    own = (c for c in measurements.conditions if c.configuration == name)
    return max((abs(r.force_N) for c in own for r in c.used()), default=0.0)


def _modulus_Pa(measurements: Measurements, sheet: SheetGeometry) -> float | None:
    """Return Young's modulus by the curves; None where they do not determine it."""
    found = shape_compliance(measurements, sheet.configuration)
    if found is None or abs(found.sigmas) < SURE_COMPLIANCE_SIGMA:
        return None
    return 12.0 / (sheet.width_m * sheet.thickness_m**3 * abs(found.value_per_Nm2))


CHECK = ForceUnit(
    name="force_unit", meaning="the size of the forces and the modulus that curves ask for", order=5
)
