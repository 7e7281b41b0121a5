"""What the solver of the world `relaxation` is given: a strip, what acts on it, and its laws.

Arrays of lanes are (n,), one entry for each equilibrium; places along the sheet are (cells, n).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]
Along = Callable[[Array, "Lanes"], Array]  # places (cells, n) -> values (cells, n)
# strain of bending (1/m) and its derivative, of a moment over B (1/m)
Bending = Callable[[Array], tuple[Array, Array]]
# angle at the clamp (rad) and its derivative, of the moment there (N m)
Hinge = Callable[[Array], tuple[Array, Array]]


# Lanes are alike where they differ by less than half of this: a force by some 1e-9 N
STEPS = {
    "beta_rad": 5e-8, "stiffness": 5e-7, "eibm_Nm": 2e-11, "curl_per_m": 1e-5, "root_rad": 1e-7,
    "slipped_m": 2e-9, "rub": 1e-6,
}  # fmt: skip
FINE = 1e-12
NOT_SOLVED = {"volts_V", "gain"}  # which `eibm_Nm` follows from


@dataclass(frozen=True, kw_only=True)
class Strip:
    """One configuration as it truly is."""

    name: str
    length_m: float
    elongation_m: float
    radius_m: float
    stiffness_Nm2: float
    eibm_per_m: tuple[float, float]  # sizes of EIBM over B at +2 V and -2 V
    nodes_m: Array
    rest_per_m: Array  # at the nodes, linear in between and constant beyond

    def _ramps(self) -> Iterator[tuple[float, float]]:
        """Yield where k0 changes its slope, and by how much."""
        slope = np.diff(self.rest_per_m) / np.diff(self.nodes_m)
        bends = np.diff(np.concatenate([[0.0], slope, [0.0]]))
        yield from zip(self.nodes_m.tolist(), bends.tolist(), strict=True)

    def rest(self, s_m: Array) -> Array:
        """Return k0 at places."""
        ramps = sum(bend * np.maximum(s_m - at, 0.0) for at, bend in self._ramps())
        return np.asarray(self.rest_per_m[0] + ramps)

    def turn(self, s_m: Array) -> Array:
        """Return the integral of k0 from the clamp, without an error of quadrature."""
        ramps = sum(0.5 * bend * np.maximum(s_m - at, 0.0) ** 2 for at, bend in self._ramps())
        return np.asarray(self.rest_per_m[0] * s_m + ramps)

    def eibm_Nm(self, volts: Array) -> Array:
        """Return the EIBM of a voltage across the sheet, in proportion to it at each polarity."""
        per_m = np.where(volts < 0.0, self.eibm_per_m[1], self.eibm_per_m[0])
        return np.asarray(self.stiffness_Nm2 * per_m * volts / 2.0)


@dataclass
class Lanes:
    """What differs from one equilibrium to the next, (n,) each."""

    beta_rad: Array  # polar angle of the cell about its pivot, and direction of its arc
    radius_m: Array  # of the cell's arc
    pivot_x_m: Array
    pivot_y_m: Array
    volts_V: Array  # that the EIBM follows
    gain: Array  # factor of the EIBM
    eibm_Nm: Array  # of both
    stiffness: Array  # factor of B
    curl_per_m: Array  # added to k0
    root_rad: Array  # angle at the clamp
    slipped_m: Array  # the sheet has come out of the clamp by this
    give_m_per_N: Array  # the cell yields along its arc
    stretch_m_per_N: Array  # it yields along the radius
    offset_m: Array  # of the cell's point from the sheet, along the sheet's normal
    swivel_Nm: Array  # per rad: the rolls resist the sheet's lean
    rub: Array  # force along the sheet over the size of the normal force, on the sheet
    drag_N: Array  # force along the sheet, on the sheet
    load_x_N_per_m: Array
    load_y_N_per_m: Array
    free: Array  # 1 where nothing holds the sheet

    @staticmethod
    def nominal(strip: Strip, count: int) -> Lanes:
        """Return so many at rest at position 0."""
        none = {f.name: np.zeros(count) for f in fields(Lanes)}
        lanes = Lanes(**none)
        lanes.radius_m += strip.radius_m
        lanes.stiffness += 1.0
        lanes.gain += 1.0
        return lanes

    def take(self, rows: Rows | Mask) -> Lanes:
        """Return some of them."""
        return Lanes(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    def alike(self) -> tuple[Rows, Rows]:
        """Return one lane of each that differ, and which of these each lane is like."""
        names = [f.name for f in fields(self) if f.name not in NOT_SOLVED]
        table = [np.round(getattr(self, n) / STEPS.get(n, FINE)) for n in names]
        _, first, back = np.unique(
            np.stack(table, axis=1), axis=0, return_index=True, return_inverse=True
        )
        return first, back.ravel()


def hookean(v: Array) -> tuple[Array, Array]:
    """Bend in proportion to the moment."""
    return v, np.ones_like(v)


def rigid(moment_Nm: Array) -> tuple[Array, Array]:
    """Hold the sheet's direction."""
    return np.zeros_like(moment_Nm), np.zeros_like(moment_Nm)


@dataclass
class Setting:
    """Laws that all equilibria of a session share."""

    eibm: list[Along] = field(default_factory=list)  # factors of the EIBM along the sheet
    softness: list[Along] = field(default_factory=list)  # factors of 1/B
    rest: list[Along] = field(default_factory=list)  # added to k0, 1/m
    bending: Bending = hookean
    hinge: Hinge = rigid
    bar_softness: float = 0.0  # B over the stiffness of the elongation
    bar_weight: float = 1.0  # of its length, over the sheet's
    beyond: float = 1.0  # factor of the EIBM beyond the contact


def product(laws: list[Along], s_m: Array, lanes: Lanes) -> Array:
    """Return the product of laws at places."""
    result = np.ones_like(s_m)
    for law in laws:
        result = result * law(s_m, lanes)
    return result


def curvature(
    strip: Strip, setting: Setting, lanes: Lanes, s_m: Array, moment_Nm: Array, eibm: float = 1.0
) -> tuple[Array, Array]:
    """Return what the curvature has beside k0 (1/m), and its derivative by the moment."""
    soft = product(setting.softness, s_m, lanes) / (strip.stiffness_Nm2 * lanes.stiffness)
    driven = eibm * lanes.eibm_Nm * product(setting.eibm, s_m, lanes)
    u, slope = setting.bending(soft * (driven + moment_Nm))
    for law in setting.rest:
        u = u + law(s_m, lanes)
    return u + lanes.curl_per_m, slope * soft
