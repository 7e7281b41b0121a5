"""The true sheets of a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.generators._elements_beam import Blade
from benchmarks.worlds.session.layout import Layout
from model.measurements import SheetGeometry

Array = npt.NDArray[np.float64]
RADIUS_M, WIDTH_M, THICKNESS_M = 40e-3, 11e-3, 0.21e-3
DEGREES = 6.0  # of Student's t, of which set-ups are drawn


def _heavy(random: np.random.Generator, n: int) -> Array:
    return random.standard_t(DEGREES, n) * np.sqrt((DEGREES - 2.0) / DEGREES)


LAYOUT = Layout(
    rise_s=0.035, series_s=0.04, run_s=70.0, wet_s=12.0, registration_m=0.015e-3,
    order_key=310, setup_key=311, drawn=_heavy,
)  # fmt: skip


@dataclass(frozen=True)
class Specimen:
    """The true sheet in one configuration."""

    blade: Blade
    eibm_per_m: tuple[float, float]  # Me/B at 2 V and -2 V
    stated: tuple[Array, Array]  # k0 of sheet.toml

    def eibm_Nm(self, volts: Array) -> Array:
        """Return the EIBM at a voltage across the sheet."""
        plus, minus = self.eibm_per_m
        per_V = np.where(volts > 0.0, plus, -minus) / 2.0
        return np.asarray(self.blade.stiffness_Nm2 * per_V * volts)


def specimens(seed: int) -> dict[str, Specimen]:
    """Return the sheets of a seed: long and short."""
    u = np.random.default_rng((seed, 301)).uniform(-1.0, 1.0, 8)
    root = 26.0 * (1.0 + 0.1 * u[0])
    level = round(28.0 * (1.0 + 0.1 * u[1]), 2)
    ratio = -0.8 - 0.1 * u[2]

    def rest(s: Array) -> Array:
        return np.asarray(root * (0.25 + 0.75 * (1.0 - s / 50e-3) ** 2))

    def one(
        length: float, bar: float, B: float, at_2_V: float, k0: Callable[[Array], Array],
        stated: tuple[Array, Array],
    ) -> Specimen:  # fmt: skip
        blade = Blade(
            length_m=length, elongation_m=bar, radius_m=RADIUS_M, rest_per_m=k0, stiffness_Nm2=B
        )
        return Specimen(blade, (at_2_V, ratio * at_2_V), stated)

    ends = np.array([0.0, 4.5e-3])
    return {
        "long": one(
            50e-3, 0.0, 1.4e-6 * (1 + 0.2 * u[3]), 28.0 * (1 + 0.2 * u[4]), rest,
            _stated(rest),
        ),
        "short": one(
            4.5e-3, 40e-3, 0.95e-6 * (1 + 0.2 * u[5]), 72.0 * (1 + 0.2 * u[6]),
            lambda s: np.full_like(s, level), (ends, np.full(2, level)),
        ),
    }  # fmt: skip


def geometry(name: str, specimen: Specimen) -> SheetGeometry:
    """Return what sheet.toml says."""
    blade = specimen.blade
    return SheetGeometry(
        configuration=name, free_length_m=blade.length_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=blade.elongation_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=specimen.stated, rise_time_s=LAYOUT.rise_s,
    )  # fmt: skip


def _stated(rest: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Return nodes whose straight lines come nearest to k0(s), to 0.01 per m."""
    nodes = np.linspace(0.0, 50e-3, 11)
    s = np.linspace(0.0, 50e-3, 2001)
    hats = np.stack([np.interp(s, nodes, row) for row in np.eye(len(nodes))], axis=1)
    return nodes, np.round(np.linalg.lstsq(hats, rest(s), rcond=None)[0], 2)
