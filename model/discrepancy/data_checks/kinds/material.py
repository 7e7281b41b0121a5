"""Width and thickness of the sheet, and the unit of the forces, by Young's modulus."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.discrepancy.data_checks.kinds._data import quoted
from model.discrepancy.thresholds import (
    SOFTEST_MODULUS_PA,
    STIFFEST_METAL_PA,
    STIFFEST_MODULUS_PA,
)
from model.measurements import Measurements

APART = 4.0  # ratio of the moduli of two sheets of one session, which are of one material as a rule


@dataclass(frozen=True)
class Material(DataCheck):
    """A stiffness that no sheet of such a size has."""

    def of_stiffness(
        self, measurements: Measurements, B_Nm2: Mapping[str, float]
    ) -> Iterator[Suspicion]:
        """See `DataCheck.of_stiffness`."""
        moduli = dict[str, float]()
        for name, B in B_Nm2.items():
            sheet = measurements.sheets[name]
            moduli[name] = 12.0 * B / (sheet.width_m * sheet.thickness_m**3)
            if not SOFTEST_MODULUS_PA < moduli[name] < STIFFEST_MODULUS_PA:
                yield self._impossible(name, moduli[name])
        if len(moduli) > 1 and max(moduli.values()) > APART * min(moduli.values()):
            yield self._unlike(measurements, moduli)

    def _impossible(self, name: str, modulus_Pa: float) -> Suspicion:
        return Suspicion(
            check=self.name, severity="warn", where=f"thickness_mm of [{name}] in sheet.toml",
            configurations=(name,),
            sentence=(
                f"the stiffness of '{name}' would mean a Young's modulus of {modulus_Pa:.1e} Pa,"
                f" {_unlike_what(modulus_Pa)}; check that forces are in mN, and width and thickness"
                " of the sheet in mm"
            ),
        )  # fmt: skip

    def _unlike(self, measurements: Measurements, moduli: Mapping[str, float]) -> Suspicion:
        soft, stiff = min(moduli, key=moduli.__getitem__), max(moduli, key=moduli.__getitem__)
        ratio = moduli[stiff] / moduli[soft]
        fits_mm = 1e3 * measurements.sheets[stiff].thickness_m * ratio ** (1.0 / 3.0)
        return Suspicion(
            check=self.name, severity="warn", where=f"thickness_mm of [{stiff}] in sheet.toml",
            configurations=(soft, stiff), value=fits_mm, unit="mm",
            sentence=(
                f"Young's moduli of {quoted([soft, stiff])} are {moduli[soft]:.1e} and"
                f" {moduli[stiff]:.1e} Pa; if they are of one material, '{stiff}' has a thickness"
                f" (thickness_mm in sheet.toml) of {fits_mm:.3g} mm, or a width of"
                f" {1e3 * measurements.sheets[stiff].width_m * ratio:.3g} mm"
            ),
        )  # fmt: skip


def _unlike_what(modulus_Pa: float) -> str:
    if modulus_Pa < SOFTEST_MODULUS_PA:
        return "as that of a gel, and no rubber"
    if modulus_Pa < STIFFEST_METAL_PA:
        return "as that of a metal, and no polymer"
    return "which no sheet has"


CHECK = Material(name="material", meaning="width and thickness against the stiffness", order=90)
