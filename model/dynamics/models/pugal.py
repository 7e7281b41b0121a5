"""After Pugal et al. 2007: the electrode line that the Poisson-Nernst-Planck model reduces to.

Seen from outside, ions that move through the thickness are a double layer behind a resistance:
a distributed line of electrodes r, capacitance c, ionic resistance rho_b, leak g_p (see
`model.dynamics.line`). The load A rho + A2 rho^2 of the charge density rho = c U gives
    k = k0 + a U + b U^2                                                 (1/m)
along the sheet; the shape follows without inertia, at any amplitude.

Own reading: this reduction. Diffusion, permittivity and concentration of the ions cannot be told
apart by a session. b U^2 bends alike for both polarities. No force: the source's sheet is free.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.dynamics.line import ElectrodeLine, LineModes
from model.dynamics.models.contract import (
    PLACES,
    DrivenSheet,
    ModelParameter,
    PublishedModel,
    Response,
)
from model.measurements import FloatArray

TERMS = 8  # Legendre polynomials of the line
BLOCK = 4096  # samples whose shapes are held in memory at once


@dataclass(frozen=True, kw_only=True)
class Pugal(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        line = LineModes(
            ElectrodeLine(
                electrode_ohm_per_m=p["r_ohm_per_m"], capacitance_F_per_m=p["c_F_per_m"],
                bulk_ohm_m=p["rho_b_ohm_m"], leak_S_per_m=p["g_p_S_per_m"],
            ), run.sheet.free_length_m, TERMS,
        )  # fmt: skip
        modes = line.respond(np.zeros(TERMS), np.diff(run.time_s), run.drive_V[:-1])
        current = line.current_A(modes, run.drive_V)
        if not run.free:
            return Response(current_A=current)
        blocks = np.array_split(modes, len(modes) // BLOCK + 1)
        tip = np.concatenate([_shapes(p, run, line, one)[1][:, -1] for one in blocks])
        return Response(
            current_A=current, tip_m=tip, curves_m=_shapes(p, run, line, modes[run.frames])
        )


def _shapes(
    p: Mapping[str, float], run: DrivenSheet, line: LineModes, modes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return x, y (n, places) of modes (n, TERMS): chords of arcs between the places."""
    s = np.linspace(0.0, run.sheet.free_length_m, PLACES)
    h, middle = s[1], 0.5 * (s[1:] + s[:-1])
    U = modes @ line.at(middle).T
    bend = h * (run.rest(middle) + p["a_per_Vm"] * U + p["b_per_V2m"] * U**2)
    phi = np.cumsum(bend, axis=1) - 0.5 * bend  # of the chords
    chord = h * np.sinc(0.5 * bend / np.pi)
    clamp = np.zeros((len(modes), 1))
    x = np.concatenate([clamp, np.cumsum(chord * np.cos(phi), axis=1)], axis=1)
    return x, np.concatenate([clamp, np.cumsum(chord * np.sin(phi), axis=1)], axis=1)


MODEL = Pugal(
    name="pugal",
    title="after Pugal et al. 2007, reduced to an electrode line",
    from_source=False,
    source="J. Appl. Phys. 2007 (accepted), as the paper cites it (not read)",
    equations="V'' = r j, j = (V - U)/rho_b + g_p V, c U_t = (V - U)/rho_b; k = k0 + a U + b U^2",
    own_reading="the reduction to a line; no electrode chemistry; shape without inertia",
    states=("U (V) along the sheet",),
    parameters=(
        ModelParameter(
            name="r_ohm_per_m", meaning="resistance of the electrodes", unit="ohm/m",
            start=2000.0, low=1.0, high=1e6,
        ),
        ModelParameter(
            name="c_F_per_m", meaning="double layer", unit="F/m", start=0.2, low=1e-4, high=100.0
        ),
        ModelParameter(
            name="rho_b_ohm_m", meaning="ionic resistance", unit="ohm m",
            start=0.5, low=1e-3, high=1e3,
        ),
        ModelParameter(
            name="g_p_S_per_m", meaning="leak", unit="S/m", start=0.05, low=1e-6, high=100.0
        ),
        ModelParameter(
            name="a_per_Vm", meaning="curvature per volt", unit="1/(V m)",
            start=30.0, low=-1e3, high=1e3, prior_scale=50.0,
        ),
        ModelParameter(
            name="b_per_V2m", meaning="curvature per volt squared", unit="1/(V2 m)",
            start=0.0, low=-500.0, high=500.0, prior_scale=5.0,
        ),
    ),
    predicts_in_contact=frozenset({"current"}),
    predicts_free=frozenset({"current", "tip", "curve"}),
)  # fmt: skip
