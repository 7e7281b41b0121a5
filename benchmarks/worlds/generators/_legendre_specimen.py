"""The sheets of the world `legendre`, and the layout of its sessions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.generators._legendre_ritz import GRID, Array
from benchmarks.worlds.session.layout import Layout
from model.measurements import SheetGeometry

RADIUS_M, WIDTH_M, THICKNESS_M = 40e-3, 11e-3, 0.21e-3
DRIVE_V, RISE_S = 2.0, 0.04
LONG, SHORT = "long", "short"
_SHEET, _ORDER, _SETUP = range(0x1E60, 0x1E63)
ODD, ODD_TIMES = 0.08, 2.2  # share of set-ups that are done carelessly, and how much worse


@dataclass(frozen=True, kw_only=True)
class Specimen:
    """One configuration as it truly is where nothing is hidden."""

    name: str
    length_m: float
    elongation_m: float
    stiffness_Nm2: float
    eibm_per_m: float  # EIBM over B at +2 V
    negative: float  # size of the EIBM at -2 V over that at +2 V
    nodes_m: Array
    rest_per_m: Array

    def grid(self) -> tuple[Array, Array]:
        """Return places on the strip, and the rest curvature at them."""
        s = np.linspace(0.0, self.length_m, GRID)
        return s, np.interp(s, self.nodes_m, self.rest_per_m)

    def amplitude(self, volts: Array) -> Array:
        """Return the EIBM over that at +2 V."""
        return np.where(volts < 0.0, self.negative, 1.0) * volts / DRIVE_V


def specimens(seed: int) -> dict[str, Specimen]:
    """Return the two configurations of a seed: one sheet, cut anew for the second."""
    r = np.random.default_rng((seed, _SHEET))
    stiffness = 1.25e-6 * np.exp(0.1 * r.standard_normal())
    curl, tail = r.uniform(17.0, 24.0), r.uniform(25e-3, 60e-3)
    nodes = np.linspace(0.0, 50e-3, 101)
    long = Specimen(
        name=LONG, length_m=50e-3, elongation_m=0.0, stiffness_Nm2=float(stiffness),
        eibm_per_m=r.uniform(22.0, 32.0), negative=r.uniform(0.72, 0.98), nodes_m=nodes,
        rest_per_m=np.round(5.0 + (curl - 5.0) * np.exp(-nodes / tail), 3),
    )  # fmt: skip
    length = float(np.round(r.uniform(4.3e-3, 5.2e-3), 5))
    short = Specimen(
        name=SHORT, length_m=length, elongation_m=42e-3,
        stiffness_Nm2=float(stiffness * r.uniform(0.65, 0.85)), eibm_per_m=r.uniform(55.0, 80.0),
        negative=r.uniform(0.72, 0.98), nodes_m=np.array([0.0, length]),
        rest_per_m=np.round(np.full(2, r.uniform(20.0, 32.0)), 3),
    )  # fmt: skip
    return {LONG: long, SHORT: short}


def geometry(name: str, true: Specimen) -> SheetGeometry:
    """Return what sheet.toml says."""
    return SheetGeometry(
        configuration=name, free_length_m=true.length_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=true.elongation_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=(true.nodes_m, true.rest_per_m),
        rise_time_s=RISE_S,
    )  # fmt: skip


def drawn(random: np.random.Generator, count: int) -> Array:
    """Return numbers of unit variance: most set-ups with the usual care, a few with less."""
    plain = random.standard_normal(count)
    careless = random.random(count) < ODD
    scale = np.sqrt(1.0 + ODD * (ODD_TIMES**2 - 1.0))
    return np.asarray(plain * np.where(careless, ODD_TIMES, 1.0) / scale)


LAYOUT = Layout(
    rise_s=RISE_S, series_s=0.05, run_s=95.0, wet_s=14.0, registration_m=9e-6, order_key=_ORDER,
    setup_key=_SETUP, drawn=drawn,
)  # fmt: skip
