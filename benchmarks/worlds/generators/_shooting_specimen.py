"""The true sheets of a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.generators._shooting_equilibrium import Strip
from benchmarks.worlds.session.layout import Layout
from model.measurements import SheetGeometry

Array = npt.NDArray[np.float64]
RADIUS_M, WIDTH_M, THICKNESS_M = 40e-3, 11e-3, 0.21e-3
REST_DECAY_M = 40e-3
LAYOUT = Layout(
    rise_s=0.025, series_s=1.0 / 30.0, run_s=55.0, wet_s=9.0, registration_m=0.02e-3,
    order_key=10, setup_key=11, drawn=lambda random, n: random.standard_normal(n),
)  # fmt: skip


@dataclass(frozen=True)
class Specimen:
    """The true sheet in one configuration."""

    strip: Strip
    eibm_per_m: tuple[float, float]  # Me/B at 2 V and -2 V
    stated: tuple[Array, Array]  # k0 of sheet.toml

    def eibm_Nm(self, volts: Array) -> Array:
        """Return the EIBM at a voltage across the sheet."""
        plus, minus = self.eibm_per_m
        per_V = np.where(volts > 0.0, plus, -minus) / 2.0
        return np.asarray(self.strip.stiffness_Nm2 * per_V * volts)


def specimens(seed: int) -> dict[str, Specimen]:
    """Return the sheets of a seed: long and short."""
    u = np.random.default_rng((seed, 1)).uniform(-1.0, 1.0, 8)
    root = 24.0 * (1.0 + 0.1 * u[0])
    level = round(28.0 * (1.0 + 0.1 * u[1]), 2)
    ratio = -0.8 - 0.1 * u[2]

    def rest(s: Array) -> Array:
        return np.asarray(root * np.exp(-s / REST_DECAY_M))

    def one(
        length: float, bar: float, B: float, at_2_V: float, k0: Callable[[Array], Array],
        stated: tuple[Array, Array],
    ) -> Specimen:  # fmt: skip
        strip = Strip(
            length_m=length, elongation_m=bar, radius_m=RADIUS_M, rest_per_m=k0, stiffness_Nm2=B
        )
        return Specimen(strip, (at_2_V, ratio * at_2_V), stated)

    ends = np.array([0.0, 4.5e-3])
    return {
        "long": one(
            50e-3, 0.0, 1.27e-6 * (1 + 0.15 * u[3]), 30.0 * (1 + 0.15 * u[4]), rest,
            _stated(rest),
        ),
        "short": one(
            4.5e-3, 40e-3, 0.85e-6 * (1 + 0.15 * u[5]), 80.0 * (1 + 0.15 * u[6]),
            lambda s: np.full_like(s, level), (ends, np.full(2, level)),
        ),
    }  # fmt: skip


def geometry(name: str, specimen: Specimen) -> SheetGeometry:
    """Return what sheet.toml says."""
    strip = specimen.strip
    return SheetGeometry(
        configuration=name, free_length_m=strip.length_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=strip.elongation_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=specimen.stated, rise_time_s=LAYOUT.rise_s,
    )  # fmt: skip


def _stated(rest: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Return nodes whose straight lines come nearest to k0(s), to 0.01 per m."""
    nodes = np.linspace(0.0, 50e-3, 11)
    s = np.linspace(0.0, 50e-3, 2001)
    hats = np.stack([np.interp(s, nodes, row) for row in np.eye(len(nodes))], axis=1)
    return nodes, np.round(np.linalg.lstsq(hats, rest(s), rcond=None)[0], 2)


def step(s: Array | float, at: Array | float, width: float) -> Array:
    """Return 0 before a place and 1 behind it."""
    return np.asarray(0.5 * (1.0 + np.tanh((np.asarray(s) - at) / width)))
