"""A rig whose sheet is a B-spline of least elastic energy.

Sealed: nobody who changes the model or the search for what it lacks looks at what this generator
hides or at what is found in its sessions, but for the figures that are reported.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from benchmarks.worlds.contract import Design, HiddenKind
from benchmarks.worlds.generators._splines_known import KINDS as KNOWN
from benchmarks.worlds.generators._splines_known import Hide
from benchmarks.worlds.generators._splines_rig import Rig
from benchmarks.worlds.generators._splines_session import measured, true_sheets
from benchmarks.worlds.generators._splines_sheet import Cases, Sheet, solve
from benchmarks.worlds.generators._splines_unknown import KINDS as UNKNOWN
from model.measurements import Measurements

__all__ = ["WORLD", "Cases", "Sheet", "solve", "true_sheets"]

ALL: dict[str, tuple[HiddenKind, Hide]] = {**KNOWN, **UNKNOWN}
# sizes that have no sense below zero
ONE_SIDED = frozenset(
    {"electrode_line", "soft_jaw", "bending_bar", "friction", "pinched", "soft_cell", "cell_play"}
    | {"diffusive_loss", "porous_electrode", "power_creep"}
)
# the catalogue's parameter, where the form is the same and the size is in its unit
SAME = {
    "clamp_angle": "angle_rad",
    "misplaced": "offset_mm",
    "roll_radius": "offset_mm",
    "tare": "force_mN",
    "soft_cell": "compliance_mm_per_mN",
    "turned_cell": "angle_rad",
    "wrong_scale": "relative_error",
}


@dataclass(frozen=True)
class Splines:
    """See `contract.World`."""

    name: str = "splines"
    numerics: str = "elastic energy minimised over B-splines, contact by a Lagrange multiplier"
    noise: str = (
        "Laplace noise of 0.03 mN with rare outliers, a zero that walks at random, curves off by "
        "0.04 mm in a frame; set-ups: EIBM and stiffness 1 %, position 0.05 mm"
    )
    kinds: Mapping[str, HiddenKind] = field(
        default_factory=lambda: {name: kind for name, (kind, _) in ALL.items()}
    )

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session; see `contract.World.measure`."""
        rig = Rig(sheets=true_sheets(seed))
        for name, size in hidden.items():
            _check(name, size)
            if size != 0.0:
                ALL[name][1](rig, size)
        return measured(rig, design, seed, exact)

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        """Return the catalogue's parameters at this size, where the form is the same."""
        _check(kind, size)
        return {SAME[kind]: size} if kind in SAME else {}

    def truth(self, seed: int) -> dict[str, dict[str, float]]:
        """Return B (N m^2) and the EIBM at +-2 V (N m) of each configuration."""
        return {
            name: {
                "B_Nm2": sheet.B_Nm2,
                "EIBM_Nm +2 V": sheet.B_Nm2 * sheet.driven_per_m[1],
                "EIBM_Nm -2 V": -sheet.B_Nm2 * sheet.driven_per_m[-1],
            }
            for name, sheet in true_sheets(seed).items()
        }


def _check(name: str, size: float) -> None:
    if name not in ALL:
        raise ValueError(f"the splines world has no kind {name!r}; it has {', '.join(ALL)}")
    largest = ALL[name][0].largest
    least = 0.0 if name in ONE_SIDED else -largest
    if not (math.isfinite(size) and least <= size <= largest):
        raise ValueError(f"the size of {name} must be from {least:g} to {largest:g}, not {size:g}")


WORLD = Splines()
