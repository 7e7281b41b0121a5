"""After Bao, Bar-Cohen and Lih 2002 and Bao et al. 2004: charge, and curvature that relaxes.

    q' = (V - q/C)/R1,   i = q' + V/R2                                   (C, A)
    kappa' = K1 q' - (kappa - K2 q)/tau                                  (1/m)
K1 (1/(C m)) acts at once, K2 (1/(C m)) after a long time; K2 < K1 is relaxation back.
The free sheet is an arc of curvature k0 + kappa. Force: linear beam of stiffness B (N m2).

Own reading: the leak R2 stands across the source; k0 is its mean in the arc; force at any contact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.dynamics.models.arc import arc_curves, arc_tip_m
from model.dynamics.models.contract import DrivenSheet, ModelParameter, PublishedModel, Response
from model.dynamics.models.held_drive import held_states
from model.dynamics.models.small_deflection import beam_response


@dataclass(frozen=True, kw_only=True)
class Bao(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        charging, K1 = 1.0 / (p["R1_ohm"] * p["C_F"]), p["K1_per_Cm"]
        A = np.array(
            [
                [-charging, 0.0],
                [p["K2_per_Cm"] / p["tau_s"] - K1 * charging, -1.0 / p["tau_s"]],
            ]
        )
        push = np.array([1.0, K1]) / p["R1_ohm"]
        q, kappa = held_states(A, push, run.time_s, run.drive_V).T
        current = (run.drive_V - q / p["C_F"]) / p["R1_ohm"] + run.drive_V / p["R2_ohm"]
        if not run.free:
            return beam_response(run, p["B_Nm2"], kappa, current)
        k = run.rest.mean(run.sheet.free_length_m) + kappa
        return Response(current_A=current, tip_m=arc_tip_m(run, k), curves_m=arc_curves(run, k))


MODEL = Bao(
    name="bao",
    title="after Bao, Bar-Cohen and Lih 2002 and Bao et al. 2004",
    from_source=False,
    source="Proc. SPIE 4695, 220 and Proc. SPIE 5385, 388-94 (not read)",
    equations="q' = (V - q/C)/R1; i = q' + V/R2; kappa' = K1 q' - (kappa - K2 q)/tau",
    own_reading="place of the leak R2; k0; force by a linear beam",
    states=("q (C)", "kappa (1/m)"),
    parameters=(
        ModelParameter(
            name="R1_ohm", meaning="resistance in series", unit="ohm", start=10.0, low=0.1, high=1e5
        ),
        ModelParameter(
            name="C_F", meaning="capacitance", unit="F", start=0.01, low=1e-6, high=10.0
        ),
        ModelParameter(name="R2_ohm", meaning="leak", unit="ohm", start=200.0, low=1.0, high=1e7),
        ModelParameter(
            name="K1_per_Cm", meaning="curvature per charge at once", unit="1/(C m)",
            start=2e3, low=-1e6, high=1e6, prior_scale=1e4,
        ),
        ModelParameter(
            name="K2_per_Cm", meaning="curvature per charge after a long time", unit="1/(C m)",
            start=2e3, low=-1e6, high=1e6, prior_scale=1e4,
        ),
        ModelParameter(
            name="tau_s", meaning="time of relaxation", unit="s", start=1.0, low=0.01, high=100.0
        ),
        ModelParameter(
            name="B_Nm2", meaning="bending stiffness", unit="N m2", start=1e-6, low=1e-9, high=1e-3
        ),
    ),
    predicts_in_contact=frozenset({"force", "current", "tip", "curve"}),
    predicts_free=frozenset({"current", "tip", "curve"}),
)  # fmt: skip
