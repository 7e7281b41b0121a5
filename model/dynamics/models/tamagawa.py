"""After Tamagawa, Yagasaki and Nogata 2002: stiffness and moment that change in time.

k = k0 + Me/B (1/m, the same all along the sheet). For a step V at t = 0:
    B(t)  = B1 + (B0 - B1) exp(-t/tB)                                    (N m2)
    Me(t) = V [m1 (1 - exp(-t/t1)) - m2 (1 - exp(-t/t2))]                (N m)
The second term is the relaxation back. Force: mean balance of moments along the arc.

Own reading: the source (an abstract was read) infers B(t) and Me(t) from measured shapes, for a
step. For any drive the two lags follow the voltage; B lags behind whether there is voltage.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.dynamics.models.arc import arc_curves, arc_tip_m, contact_arc
from model.dynamics.models.contract import DrivenSheet, ModelParameter, PublishedModel, Response
from model.dynamics.models.held_drive import lag

LEAST_V = 0.1  # less is an amplifier's offset, no voltage


@dataclass(frozen=True, kw_only=True)
class Tamagawa(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        t, V = run.time_s, run.drive_V
        on = lag(p["tB_s"], t, (np.abs(V) > LEAST_V).astype(float))
        B = p["B0_Nm2"] + (p["B1_Nm2"] - p["B0_Nm2"]) * on
        moment = p["m1_Nm_per_V"] * lag(p["t1_s"], t, V) - p["m2_Nm_per_V"] * lag(p["t2_s"], t, V)
        if not run.free:
            arc = contact_arc(run)
            k = np.full(len(t), arc.curvature_per_m)
            force = B * arc.force_over_B(moment / B)
            return Response(force_N=force, tip_m=arc_tip_m(run, k), curves_m=arc_curves(run, k))
        k = run.rest.mean(run.sheet.free_length_m) + moment / B
        return Response(tip_m=arc_tip_m(run, k), curves_m=arc_curves(run, k))


def _stiffness(name: str, meaning: str) -> ModelParameter:
    return ModelParameter(name=name, meaning=meaning, unit="N m2", start=1e-6, low=1e-9, high=1e-3)


MODEL = Tamagawa(
    name="tamagawa",
    title="after Tamagawa, Yagasaki and Nogata 2002",
    from_source=False,
    source="J. Appl. Phys. 92, 7614; abstract of Yagasaki and Tamagawa, PRE 70, 052801",
    equations="k = k0 + Me/B; B = B1 + (B0 - B1) exp(-t/tB); Me of two lags of V",
    own_reading="lags for any drive; B follows whether there is voltage; force by the mean moment",
    states=("stiffness lag (1)", "moment lag (V)", "relaxation lag (V)"),
    parameters=(
        _stiffness("B0_Nm2", "stiffness without voltage"),
        _stiffness("B1_Nm2", "stiffness under voltage, after a long time"),
        ModelParameter(
            name="tB_s", meaning="time of the stiffness", unit="s", start=1.0, low=1e-2, high=100.0
        ),
        ModelParameter(
            name="m1_Nm_per_V", meaning="moment per volt", unit="N m/V",
            start=3e-5, low=-1e-2, high=1e-2, prior_scale=1e-4,
        ),
        ModelParameter(
            name="t1_s", meaning="time of the moment", unit="s", start=0.1, low=1e-3, high=10.0
        ),
        ModelParameter(
            name="m2_Nm_per_V", meaning="moment per volt that relaxes back", unit="N m/V",
            start=3e-6, low=-1e-2, high=1e-2, prior_scale=1e-4,
        ),
        ModelParameter(
            name="t2_s", meaning="time of the relaxation", unit="s", start=2.0, low=0.1, high=100.0
        ),
    ),
    predicts_in_contact=frozenset({"force", "tip", "curve"}),
    predicts_free=frozenset({"tip", "curve"}),
)  # fmt: skip
