"""The world `legendre`: sheets by the method of Ritz, a 16 bit board on a floor that swings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._legendre_beyond import BEYOND
from benchmarks.worlds.generators._legendre_further import FURTHER
from benchmarks.worlds.generators._legendre_known import KNOWN
from benchmarks.worlds.generators._legendre_noise import POINT_M, WAVE_M, RunNoise, quantised
from benchmarks.worlds.generators._legendre_plant import FINER, taken
from benchmarks.worlds.generators._legendre_rig import RIG
from benchmarks.worlds.generators._legendre_specimen import LAYOUT, geometry, specimens
from benchmarks.worlds.session.world import SessionWorld
from model.measurements import Condition, Measurements, TimeSeries


@dataclass(frozen=True, kw_only=True)
class LegendreWorld(SessionWorld):
    """Sessions in the common layout, read by a board of 16 bits."""

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session; see the contract."""
        found = super().measure(design, hidden, seed, exact=exact)
        if exact:
            return found
        return replace(
            found,
            conditions=tuple(_read(one) for one in found.conditions),
            series=tuple(_recorded(one) for one in found.series),
        )


def _read(one: Condition) -> Condition:
    shown = quantised(np.array([r.force_N for r in one.readings]))
    pairs = zip(one.readings, shown.tolist(), strict=True)
    return replace(one, readings=tuple(replace(r, force_N=force) for r, force in pairs))


def _recorded(one: TimeSeries) -> TimeSeries:
    return one if one.force_N is None else replace(one, force_N=quantised(one.force_N))


WORLD = LegendreWorld(
    name="legendre",
    numerics="Ritz: Legendre series of the curvature, Gauss quadrature, Newton with a multiplier",
    noise=(
        "steps of a 16 bit board, white noise, a zero that walks at random, a floor that swings in"
        " bursts; images that lie aside and turned, each near the one before; blurred edges;"
        " set-ups of which a few are careless"
    ),
    acts={**KNOWN, **RIG, **FURTHER, **BEYOND},
    layout=LAYOUT,
    sheets=specimens,
    geometry=geometry,
    taken=taken,
    run_noise=RunNoise,
    point_m=POINT_M,
    wave_m=WAVE_M,
    finer=FINER,
)
