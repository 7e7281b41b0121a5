"""How large a session is: what is usual of 50 mm and a few mN is usual of others in proportion.

Numbers of model and search that are lengths or forces (scatter of set-ups, noise before it is
estimated, amplitudes that would surprise nobody) were found on sheets of the paper's size. For
others they are multiplied by these factors. Sessions of about the paper's size have its numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from model.measurements.data import FloatArray, Measurements, SheetGeometry

# the paper's, and between which factors of them a session is of its size
RADIUS_M, ABOUT_RADIUS = 0.04, (0.29, 1.4)
FORCE_N, ABOUT_FORCE = 3e-3, (0.1, 10.0)
LOAD_N = 8e-4  # B over the square of the arc's radius, for the same forces
HIGH = 90.0  # per cent of the forces that are smaller than the one that counts


@dataclass(frozen=True)
class RigScale:
    """Lengths and forces of a session over those of the paper."""

    length: float = 1.0
    force: float = 1.0

    @property
    def per_length(self) -> float:
        """Of a curvature."""
        return 1.0 / self.length

    def of_unit(self, unit: str) -> float:
        """Return the factor of a number by its unit; 1 of what is neither length nor force."""
        return {
            "mm": self.length, "m": self.length, "mN": self.force, "1/m": 1.0 / self.length,
            "mm/mN": self.length / self.force, "N/m": self.force / self.length,
            "rad/(N m)": 1.0 / (self.force * self.length),
        }.get(unit, 1.0)  # fmt: skip


def length_scale(sheet: SheetGeometry) -> float:
    """Return the factor of lengths of a sheet, by its arc: sheets of one rig have the same."""
    return _unless_about(sheet.arc_radius_m / RADIUS_M, ABOUT_RADIUS)


def load_scale(sheet: SheetGeometry, B_Nm2: FloatArray) -> float:
    """Return the factor of forces by a sheet's stiffness, where no measured ones are known."""
    natural_N = float(np.median(B_Nm2)) / sheet.arc_radius_m**2
    return _unless_about(natural_N / LOAD_N, ABOUT_FORCE)


def scale_of(sheets: Iterable[SheetGeometry], forces_N: FloatArray) -> RigScale:
    """Return the scale of a session by its sheets and all its forces."""
    sizes = np.abs(forces_N[np.isfinite(forces_N)])
    force_N = float(np.percentile(sizes, HIGH)) if len(sizes) else 0.0
    lengths = [length_scale(one) for one in sheets]
    return RigScale(
        length=max(lengths, default=1.0), force=_unless_about(force_N / FORCE_N, ABOUT_FORCE)
    )


def scale_of_measurements(measurements: Measurements) -> RigScale:
    """Return the scale by the readings in use."""
    used = [c for c in measurements.conditions if c.position_m is not None]
    forces: npt.NDArray[np.float64] = np.array([r.force_N for c in used for r in c.used()])
    return scale_of(measurements.sheets.values(), forces)


def _unless_about(ratio: float, about: tuple[float, float]) -> float:
    """Return a ratio; 1 of one that is about 1, or that says nothing."""
    return ratio if 0.0 < ratio < np.inf and not about[0] < ratio < about[1] else 1.0
