"""How large a session is: what is usual of 50 mm and a few mN is usual of others in proportion.

Numbers of model and search that are lengths or forces (scatter of set-ups, noise before it is
estimated, amplitudes that would surprise nobody) were found on sheets of the paper's size. For
others they are multiplied by these factors. Factors go in steps, so that all sessions of about the
paper's size have exactly its numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from model.measurements.data import FloatArray, Measurements, SheetGeometry

LEAST_RADIUS_M, LENGTH_STEP = 0.012, 10.0  # arcs of 12 to 120 mm are of the paper's size
LEAST_FORCE_N, FORCE_STEP = 3e-4, 100.0  # forces of 0.3 to 30 mN are
LEAST_LOAD_N = 8e-5  # B over the square of the arc's radius, for the same forces
HIGH = 90.0  # per cent of the forces that are smaller than the one that counts


@dataclass(frozen=True)
class RigScale:
    """Lengths and forces of a session over those of the paper, in steps."""

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
    return _in_steps(sheet.arc_radius_m / LEAST_RADIUS_M, LENGTH_STEP)


def load_scale(sheet: SheetGeometry, B_Nm2: FloatArray) -> float:
    """Return the factor of forces by a sheet's stiffness, where no measured ones are known."""
    natural_N = float(np.median(B_Nm2)) / sheet.arc_radius_m**2
    return _in_steps(natural_N / LEAST_LOAD_N, FORCE_STEP)


def scale_of(sheets: Iterable[SheetGeometry], forces_N: FloatArray) -> RigScale:
    """Return the scale of a session by its sheets and all its forces."""
    sizes = np.abs(forces_N[np.isfinite(forces_N)])
    force_N = float(np.percentile(sizes, HIGH)) if len(sizes) else 0.0
    lengths = [length_scale(one) for one in sheets]
    return RigScale(
        length=max(lengths, default=1.0), force=_in_steps(force_N / LEAST_FORCE_N, FORCE_STEP)
    )


def scale_of_measurements(measurements: Measurements) -> RigScale:
    """Return the scale by the readings in use."""
    used = [c for c in measurements.conditions if c.position_m is not None]
    forces: npt.NDArray[np.float64] = np.array([r.force_N for c in used for r in c.used()])
    return scale_of(measurements.sheets.values(), forces)


def _in_steps(ratio: float, step: float) -> float:
    """Return the power of `step` at or below a ratio; 1 of a ratio that says nothing."""
    if not 0.0 < ratio < np.inf:
        return 1.0
    exponent = int(np.floor(np.log(ratio) / np.log(step) + 1e-9))
    return float(step**exponent)
