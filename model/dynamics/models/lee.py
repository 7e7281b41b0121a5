"""After Lee, Park and Kim 2005: the sheet as a piezoelectric bimorph.

    tip = 3 d31 U l^2/(2 d^2),   blocked force at the tip = 3 w d E d31 U/(8 l)
that is kappa = 3 d31 U/d^2 and B = E w d^3/12 of a linear beam, which the contact bends at any
place. d31 (m/V), E (Pa); l, w, d: length, width, thickness (m). The source is static.

Own reading: the voltage acts with one lag, tau U' = V - U; k0; contact anywhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from model.dynamics.models.contract import DrivenSheet, ModelParameter, PublishedModel, Response
from model.dynamics.models.held_drive import lag
from model.dynamics.models.small_deflection import beam_response


@dataclass(frozen=True, kw_only=True)
class Lee(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        width, thick = run.sheet.width_m, run.sheet.thickness_m
        B = p["E_Pa"] * width * thick**3 / 12.0
        kappa = 3.0 * p["d31_m_per_V"] / thick**2 * lag(p["charging_s"], run.time_s, run.drive_V)
        return beam_response(run, B, kappa)


MODEL = Lee(
    name="lee",
    title="after Lee, Park and Kim 2005",
    from_source=False,
    source="Lee S, Park H C and Kim K J 2005, Smart Mater. Struct. 14, 1363 (not read)",
    equations="tip = 3 d31 U l^2/(2 d^2); blocked force = 3 w d E d31 U/(8 l)",
    own_reading="U lags behind V; k0; contact at any place of a linear beam",
    states=("U (V)",),
    parameters=(
        ModelParameter(
            name="E_Pa", meaning="Young's modulus", unit="Pa", start=1e8, low=1e5, high=1e11
        ),
        ModelParameter(
            name="d31_m_per_V", meaning="piezoelectric constant", unit="m/V",
            start=5e-7, low=-1e-4, high=1e-4, prior_scale=2e-6,
        ),
        ModelParameter(
            name="charging_s", meaning="time of charging", unit="s", start=0.1, low=1e-3, high=10.0
        ),
    ),
    predicts_in_contact=frozenset({"force", "tip", "curve"}),
    predicts_free=frozenset({"tip", "curve"}),
)  # fmt: skip
