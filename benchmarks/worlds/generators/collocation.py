"""A rig whose strip is a boundary-value problem on Chebyshev nodes.

Sealed: nobody who changes the model or the search for what it lacks looks at what this generator
hides or at what is found in its sessions, but for the figures that are reported.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from benchmarks.worlds.contract import Design, HiddenKind
from benchmarks.worlds.generators._collocation_bvp import Problem, Strip, solved
from benchmarks.worlds.generators._collocation_named import NAMED, Spoil
from benchmarks.worlds.generators._collocation_nameless import NAMELESS
from benchmarks.worlds.generators._collocation_plant import Plant
from benchmarks.worlds.generators._collocation_session import PINK_N, Noise, session, specimens
from model.measurements import Measurements

__all__ = ["PINK_N", "WORLD", "Noise", "Problem", "Strip", "solved", "specimens"]

EVERY: dict[str, tuple[HiddenKind, Spoil]] = {**NAMED, **NAMELESS}
POSITIVE = (
    "contact_resistance", "sprung_clamp", "glued_joint", "dragging_rolls", "stick_slip",
    "stiffening_arm", "lazy_gauge", "water_returns", "slow_capacitor", "standard_solid",
    "slow_filter",
)  # fmt: skip
# the catalogue's parameter, where the formula is the catalogue's
PARAMETER = {
    "wedge": "angle_rad",
    "leaning": "load_N_per_m",
    "sprung_clamp": "rotation_rad_per_Nm",
    "zero": "force_mN",
    "slow_capacitor": "time_constant_s",
}


class Collocation:
    """See `contract.World`."""

    name = "collocation"
    numerics = "boundary-value problem collocated on 27 Chebyshev nodes, Newton's method"
    noise = (
        "white noise of 0.022 mN and pink noise of 0.01 mN, steps of 0.01 mN of the converter and "
        "of 0.06 mm of the stage, curves off by 0.04 mm in a frame; set-ups: EIBM and stiffness "
        "1 %, position 0.05 mm"
    )
    kinds: Mapping[str, HiddenKind] = MappingProxyType({k: v[0] for k, v in EVERY.items()})

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session; see `contract.World.measure`."""
        plant = Plant(strips=specimens(seed))
        for name, size in hidden.items():
            _refuse(name, size)
            if size:
                EVERY[name][1](plant, size)
        return session(plant, design, seed, exact)

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        """Return the catalogue's parameter where the formula is the same."""
        _refuse(kind, size)
        return {PARAMETER[kind]: size} if kind in PARAMETER else {}

    def truth(self, seed: int) -> dict[str, dict[str, float]]:
        """Return B (N m^2) and the EIBM at +-2 V (N m) of each configuration."""
        return {
            name: {
                "B_Nm2": strip.B_Nm2,
                "EIBM_Nm +2 V": strip.B_Nm2 * strip.bends_per_m[0],
                "EIBM_Nm -2 V": strip.B_Nm2 * strip.bends_per_m[1],
            }
            for name, strip in specimens(seed).items()
        }


def _refuse(name: str, size: float) -> None:
    """Raise ValueError for a kind or size that there is not."""
    if name not in EVERY:
        raise ValueError(f"the collocation world has no kind {name!r}; it has {', '.join(EVERY)}")
    kind = EVERY[name][0]
    lowest = 0.0 if name in POSITIVE else -kind.largest
    if not (math.isfinite(size) and lowest <= size <= kind.largest):
        raise ValueError(
            f"{name} is a size from {lowest:g} to {kind.largest:g} {kind.unit}, not {size:g}"
        )


WORLD = Collocation()
