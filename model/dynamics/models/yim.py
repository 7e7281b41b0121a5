"""After Yim, Trabia, Renno, Lee and Kim 2006: rigid links with RC cells in their joints.

    q' = (V - q/C)/R, i = q' (A);   Me = km q (N m), the same in all joints, whose cells are equal
    links: springs B/h, dampers B eta/h, mass mu h, quadratic drag c_q; any amplitude
See `moving_chain` (free) and `chain` (contact). km (N m/C), eta (s), c_q (N s2/m3).

Own reading: ten links; in contact without inertia; the elongation has no mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.dynamics.models.chain import LINKS, Chain, ChainContact, chain_of
from model.dynamics.models.contract import DrivenSheet, ModelParameter, PublishedModel, Response
from model.dynamics.models.held_drive import lag
from model.measurements import FloatArray, ModelError


@dataclass(frozen=True, kw_only=True)
class Yim(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        U = lag(p["R_ohm"] * p["C_F"], run.time_s, run.drive_V)
        current = (run.drive_V - U) / p["R_ohm"]
        if run.wanted == {"current"}:
            return Response(current_A=current)
        chain, bend = chain_of(run), p["km_Nm_per_C"] * p["C_F"] / p["B_Nm2"]
        force = None
        if run.free:
            angles = _moving(p, run, chain, bend * U)
        else:
            at = ChainContact(chain, run.sheet.arc_radius_m, run.angle_rad)
            force, angles = at.at(bend * U)
            force = p["B_Nm2"] * force
        x, y = (one[:, : LINKS + 1] for one in chain.joints(angles))
        return Response(
            force_N=force, current_A=current, tip_m=y[:, -1],
            curves_m=(x[run.frames], y[run.frames]),
        )  # fmt: skip


def _moving(
    p: Mapping[str, float], run: DrivenSheet, chain: Chain, kappa: FloatArray
) -> FloatArray:
    """Return the links' directions (n, links); until 0 s as they are there."""
    from model.dynamics.models.moving_chain import inertia_of, march  # compiled

    h, first = float(chain.link_m[0]), int(np.searchsorted(run.time_s, 0.0))
    inertia = inertia_of(len(chain.link_m), h, p["mu_kg_per_m"])
    final = p["km_Nm_per_C"] * p["C_F"] / p["B_Nm2"] * run.drive_V
    charge = kappa[first:], final[first:], p["R_ohm"] * p["C_F"]
    angles = march(
        (inertia, h), p["B_Nm2"] / chain.cell_m, chain.cell_m, chain.rest_rad, charge,
        np.diff(run.time_s[first:]), (p["eta_s"], p["drag_Ns2_per_m3"]),
    )  # fmt: skip
    if not np.all(np.isfinite(angles)):
        raise ModelError("the chain of links moves too fast to be followed")
    return np.concatenate([np.repeat(angles[:1], first, axis=0), angles])


MODEL = Yim(
    name="yim",
    title="after Yim, Trabia, Renno, Lee and Kim 2006",
    from_source=False,
    source="Proc. IROS 2006 (Beijing) (not read)",
    equations="q' = (V - q/C)/R; Me = km q; links with springs, dampers, mass and drag",
    own_reading="ten links; contact without inertia; elongation without mass; quadratic drag",
    states=("q (C)", "direction (rad) and its rate (rad/s) of each link"),
    parameters=(
        ModelParameter(
            name="R_ohm", meaning="resistance of all cells", unit="ohm",
            start=10.0, low=0.1, high=1e5,
        ),
        ModelParameter(
            name="C_F", meaning="capacitance of all cells", unit="F",
            start=0.01, low=1e-6, high=10.0,
        ),
        ModelParameter(
            name="km_Nm_per_C", meaning="moment per charge", unit="N m/C",
            start=3e-3, low=-10.0, high=10.0, prior_scale=1e-2,
        ),
        ModelParameter(
            name="B_Nm2", meaning="bending stiffness", unit="N m2", start=1e-6, low=1e-9, high=1e-3
        ),
        ModelParameter(
            name="mu_kg_per_m", meaning="mass per length", unit="kg/m",
            start=5e-3, low=1e-5, high=1.0,
        ),
        ModelParameter(
            name="eta_s", meaning="time of the dampers", unit="s", start=1e-3, low=1e-6, high=0.1
        ),
        ModelParameter(
            name="drag_Ns2_per_m3", meaning="quadratic drag", unit="N s2/m3",
            start=0.01, low=1e-5, high=100.0,
        ),
    ),
    predicts_in_contact=frozenset({"force", "current", "tip", "curve"}),
    predicts_free=frozenset({"current", "tip", "curve"}),
)  # fmt: skip
