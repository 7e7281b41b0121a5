"""The true sheets of a seed, and how a session of this world goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.generators._magnus_rod import Rod
from benchmarks.worlds.session.layout import Layout, Run
from model.measurements import SheetGeometry

Array = npt.NDArray[np.float64]
RADIUS_M, WIDTH_M, THICKNESS_M = 42e-3, 10e-3, 0.2e-3
LONG_M, SHORT_M, BAR_M = 54e-3, 5e-3, 45e-3
JITTER = 4e-4  # of the scale, from one picture to the next


def _logistic(random: np.random.Generator, n: int) -> Array:
    return random.logistic(0.0, np.sqrt(3.0) / np.pi, n)


LAYOUT = Layout(
    rise_s=0.03, series_s=0.04, run_s=62.0, wet_s=14.0, registration_m=0.02e-3,
    order_key=4701, setup_key=4702, drawn=_logistic, position_m=0.06e-3, eibm=0.012,
    stiffness=0.008,
)  # fmt: skip


@dataclass(frozen=True)
class Specimen:
    """The true sheet in one configuration."""

    rod: Rod
    eibm_per_m: tuple[float, float]  # Me/B at 2 V and -2 V
    stated: tuple[Array, Array]  # k0 of sheet.toml
    seed: int

    def eibm_Nm(self, volts: Array) -> Array:
        """Return the EIBM at a voltage across the sheet."""
        plus, minus = self.eibm_per_m
        per_V = np.where(volts > 0.0, plus, -minus) / 2.0
        return np.asarray(self.rod.stiffness_Nm2 * per_V * volts)

    def jitter(self, run: Run, count: int) -> Array:
        """Return the scale of each picture of a run; 1 where nothing is left to chance."""
        z = np.random.default_rng((self.seed, 4703, run.number)).standard_normal(count)
        nominal = run.tau[0] == run.tau[1]
        return np.asarray(1.0 + JITTER * z * (not nominal))


def specimens(seed: int) -> dict[str, Specimen]:
    """Return the sheets of a seed: long and short."""
    u = np.random.default_rng((seed, 4700)).uniform(-1.0, 1.0, 8)
    root = 22.0 * (1.0 + 0.12 * u[0])
    level = round(25.0 * (1.0 + 0.12 * u[1]), 2)
    ratio = -0.86 - 0.08 * u[2]

    def rest(s: Array) -> Array:
        return np.asarray(root * (0.4 + 0.6 * np.cos(0.5 * np.pi * s / LONG_M) ** 2))

    def one(
        length: float, bar: float, B: float, at_2_V: float, k0: Callable[[Array], Array],
        stated: tuple[Array, Array],
    ) -> Specimen:  # fmt: skip
        rod = Rod(
            length_m=length, elongation_m=bar, radius_m=RADIUS_M, rest_per_m=k0, stiffness_Nm2=B
        )
        return Specimen(rod, (at_2_V, ratio * at_2_V), stated, seed)

    return {
        "long": one(
            LONG_M, 0.0, 1.35e-6 * (1 + 0.18 * u[3]), 26.0 * (1 + 0.18 * u[4]), rest, _stated(rest)
        ),
        "short": one(
            SHORT_M, BAR_M, 1.0e-6 * (1 + 0.18 * u[5]), 66.0 * (1 + 0.18 * u[6]),
            lambda s: np.full_like(s, level), (np.array([0.0, SHORT_M]), np.full(2, level)),
        ),
    }  # fmt: skip


def geometry(name: str, specimen: Specimen) -> SheetGeometry:
    """Return what sheet.toml says."""
    rod = specimen.rod
    return SheetGeometry(
        configuration=name, free_length_m=rod.length_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=rod.elongation_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=specimen.stated, rise_time_s=LAYOUT.rise_s,
    )  # fmt: skip


def _stated(rest: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Return nodes whose straight lines come nearest to k0(s), to 0.01 per m."""
    nodes = np.linspace(0.0, LONG_M, 13)
    s = np.linspace(0.0, LONG_M, 2401)
    hats = np.stack([np.interp(s, nodes, row) for row in np.eye(len(nodes))], axis=1)
    return nodes, np.round(np.linalg.lstsq(hats, rest(s), rcond=None)[0], 2)
