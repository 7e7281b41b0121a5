"""After Huynh, Alici and Spinks 2006: force of a quasi-static bending actuator.

F = B (y_free(R) - R beta)/compliance, y_free of a linear beam with the moment Me = gain U (N m).
Own reading: tau U' = V - U, and one B for the layers, whose thicknesses a session does not tell.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from model.dynamics.models.contract import DrivenSheet, ModelParameter, PublishedModel, Response
from model.dynamics.models.held_drive import lag
from model.dynamics.models.small_deflection import small_deflection


@dataclass(frozen=True, kw_only=True)
class HuynhAlici(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        if run.free:
            return Response()
        U = lag(p["tau_s"], run.time_s, run.drive_V)
        B = p["B_Nm2"]
        return Response(force_N=B * small_deflection(run).force_over_B(p["gain_Nm_per_V"] / B * U))


MODEL = HuynhAlici(
    name="huynh_alici",
    title="after Huynh, Alici and Spinks 2006",
    from_source=False,
    source="Proc. IROS 2006 (Beijing), 5465-70 (not read)",
    equations="F = B (y_free(R) - R beta)/compliance; Me = gain U",
    own_reading="U lags behind V; one stiffness for all layers; k0",
    states=("U (V)",),
    parameters=(
        ModelParameter(
            name="B_Nm2", meaning="bending stiffness", unit="N m2", start=1e-6, low=1e-9, high=1e-3
        ),
        ModelParameter(
            name="gain_Nm_per_V", meaning="moment per volt", unit="N m/V",
            start=3e-5, low=-1e-2, high=1e-2, prior_scale=1e-4,
        ),
        ModelParameter(
            name="tau_s", meaning="time of the lag", unit="s", start=0.1, low=1e-3, high=10.0
        ),
    ),
    predicts_in_contact=frozenset({"force"}),
    predicts_free=frozenset(),
)  # fmt: skip
