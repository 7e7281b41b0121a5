"""The unit of the forces, by their size and by the modulus that the curves ask for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import DataCheck, Severity, Suspicion
from model.discrepancy.data_checks.kinds._data import quoted
from model.discrepancy.data_checks.shape_compliance import shape_compliance
from model.discrepancy.thresholds import (
    LARGEST_FORCE_N,
    MOST_ON_POLYMER_V,
    SMALLEST_FORCE_N,
    SOFTEST_MODULUS_PA,
    STIFFEST_BY_CURVES_PA,
    STIFFEST_METAL_PA,
    SURE_COMPLIANCE_SIGMA,
)
from model.measurements import Measurements, SheetGeometry, in_digits, length_scale

METAL = "; where the strip is of metal they may be right"
UNITS = {1e3: "N", 1e-3: "µN, or in mN and taken for N"}


@dataclass(frozen=True)
class ForceUnit(DataCheck):
    """Newtons among millinewtons.

    A strip of metal is as stiff. No ionic polymer bears its voltages, so that above these it is
    only asked about. Where only the modulus is odd, width or thickness may be wrong; that is the
    material's check.
    """

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        for name, sheet in measurements.sheets.items():
            largest_N = _largest_N(measurements, name)
            area = length_scale(sheet) ** 2  # forces go with the section of a strip
            if not largest_N or SMALLEST_FORCE_N < largest_N / area < LARGEST_FORCE_N:
                continue
            modulus_Pa = _modulus_Pa(measurements, sheet)
            if modulus_Pa is None or SOFTEST_MODULUS_PA < modulus_Pa < STIFFEST_BY_CURVES_PA:
                continue
            factor = 1e3 if largest_N / area <= SMALLEST_FORCE_N else 1e-3
            if SOFTEST_MODULUS_PA < factor * modulus_Pa < STIFFEST_BY_CURVES_PA:
                may_be_metal = factor < 1.0 and modulus_Pa < STIFFEST_METAL_PA
                no_polymer = _largest_V(measurements, name) > MOST_ON_POLYMER_V
                yield self._suspicion(
                    name, largest_N, modulus_Pa, factor,
                    "warn" if may_be_metal and no_polymer else "stop",
                )  # fmt: skip

    def _suspicion(
        self, name: str, largest_N: float, modulus_Pa: float, factor: float, severity: Severity
    ) -> Suspicion:
        return Suspicion(
            check=self.name, severity=severity, where="force_mN", configurations=(name,),
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


def _largest_V(measurements: Measurements, name: str) -> float:
    own = (c for c in measurements.conditions if c.configuration == name)
    return max((abs(c.voltage_V) for c in own), default=0.0)


def _modulus_Pa(measurements: Measurements, sheet: SheetGeometry) -> float | None:
    """Return Young's modulus by the curves; None where they do not determine it."""
    found = shape_compliance(measurements, sheet.configuration)
    if found is None or abs(found.sigmas) < SURE_COMPLIANCE_SIGMA:
        return None
    return 12.0 / (sheet.width_m * sheet.thickness_m**3 * abs(found.value_per_Nm2))


CHECK = ForceUnit(
    name="force_unit", meaning="the size of the forces and the modulus that curves ask for", order=5
)
