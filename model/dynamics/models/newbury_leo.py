"""After Newbury and Leo 2003: an electromechanical two-port with a viscoelastic modulus.

Port deflection u from the shape at rest (m), force f (N); U on the capacitor (V), charge Q (C):
    f = K*(p)(u - s U) + M u'',   Q = C U - s K*(p)(u - s U),   Q' = (V - U)/R,  i = Q' + V/R_dc
    K* = K [1 + a (p^2 + 2 z w p)/(p^2 + 2 z w p + w^2)]                 (one GHM term)
Tip: K = 3 B/l^3, M = 33/140 mu l, s = 3 d l^2/(2 h^2), h the thickness, d the effective strain
coefficient (m/V). One s in both equations makes sensing and actuation reciprocal.

Own reading: in contact the port is there (K and s of a linear beam), held, so without inertia; k0;
the free sheet is a parabola, u x^2/l^2, beside k0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.models.contract import (
    PLACES,
    DrivenSheet,
    ModelParameter,
    PublishedModel,
    Response,
)
from model.dynamics.models.held_drive import held_states
from model.dynamics.models.small_deflection import small_deflection
from model.measurements import FloatArray
from model.mechanics.linear_beam import heights_m


@dataclass(frozen=True)
class _Port:
    """Where force and deflection are those of the two-port."""

    stiffness_N_per_m: float  # K
    free_m_per_V: float  # s

    def elastic_force(self, p: Mapping[str, float], e: FloatArray, z: FloatArray) -> FloatArray:
        """Return K*(u - s U) of e = u - s U and its GHM coordinate z."""
        a = p["ghm_share"]
        return np.asarray(self.stiffness_N_per_m * ((1.0 + a) * e - a * z))


@dataclass(frozen=True, kw_only=True)
class NewburyLeo(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        beam = small_deflection(run)
        if run.free:
            beam = replace(beam, contact_m=run.sheet.free_length_m)
        kappa_per_V = 3.0 * p["d_m_per_V"] / run.sheet.thickness_m**2
        port = _Port(p["B_Nm2"] / beam.compliance_m3, kappa_per_V * beam.bent_m2)
        mass = 33.0 / 140.0 * p["mu_kg_per_m"] * run.sheet.free_length_m
        A, B = _system(p, port, mass if run.free else None)
        x = held_states(A, B, run.time_s, run.drive_V)
        U, z = x[:, 0], x[:, 1]
        u = x[:, 3] if run.free else np.zeros_like(U)
        source = (run.drive_V - U) / p["R_ohm"]
        current = source + run.drive_V / p["Rdc_ohm"]
        if run.free:
            x = np.linspace(0.0, run.sheet.free_length_m, PLACES)
            by_u = np.outer(u[run.frames], (x / run.sheet.free_length_m) ** 2)
            y = heights_m(run.rest, x) + by_u
            return Response(
                current_A=current, tip_m=beam.off_at_rest_m + u,
                curves_m=(np.broadcast_to(x, y.shape), y),
            )  # fmt: skip
        held = port.stiffness_N_per_m * beam.off_at_rest_m
        force = held - port.elastic_force(p, u - port.free_m_per_V * U, z)
        return Response(force_N=force, current_A=current)


def _system(
    p: Mapping[str, float], port: _Port, mass_kg: float | None
) -> tuple[FloatArray, FloatArray]:
    """Return A, B of U, z, z', and of u, u' where the port moves (a mass is given)."""
    s, K, a, w = port.free_m_per_V, port.stiffness_N_per_m, p["ghm_share"], p["ghm_rad_per_s"]
    n = 3 if mass_kg is None else 5
    A, B = np.zeros((n, n)), np.zeros(n)
    # Q' = (V - U)/R with Q = C U - s K [(1 + a)(u - s U) - a z]
    capacitance = p["C_F"] + s**2 * K * (1.0 + a)
    A[0, 0], B[0] = -1.0 / (p["R_ohm"] * capacitance), 1.0 / (p["R_ohm"] * capacitance)
    A[0, 2] = -s * K * a / capacitance
    A[1, 2] = 1.0
    A[2, :3] = -(w**2) * s, -(w**2), -2.0 * p["ghm_damping"] * w
    if mass_kg is not None:
        A[0, 4] = s * K * (1.0 + a) / capacitance
        A[2, 3] = w**2
        A[3, 4] = 1.0
        A[4, :4] = np.array([(1.0 + a) * s, a, 0.0, -(1.0 + a)]) * K / mass_kg
    return A, B


MODEL = NewburyLeo(
    name="newbury_leo",
    title="after Newbury and Leo 2003",
    from_source=False,
    source="J. Intell. Mater. Syst. Struct. 14, 333-42 and 343 (abstracts read)",
    equations="f = K*(u - s U) + M u''; Q = C U - s K*(u - s U); Q' = (V - U)/R; i = Q' + V/R_dc",
    own_reading="one GHM term; s without relaxation; port at the contact; k0; a free parabola",
    states=("U (V)", "z (m)", "z' (m/s)", "u (m)", "u' (m/s)"),
    parameters=(
        ModelParameter(
            name="R_ohm", meaning="resistance in series", unit="ohm", start=10.0, low=0.1, high=1e5
        ),
        ModelParameter(
            name="C_F", meaning="capacitance of the free sheet", unit="F",
            start=0.01, low=1e-6, high=10.0,
        ),
        ModelParameter(name="Rdc_ohm", meaning="leak", unit="ohm", start=200.0, low=1.0, high=1e7),
        ModelParameter(
            name="d_m_per_V", meaning="effective strain coefficient", unit="m/V",
            start=5e-7, low=-1e-4, high=1e-4, prior_scale=2e-6,
        ),
        ModelParameter(
            name="B_Nm2", meaning="bending stiffness, relaxed", unit="N m2",
            start=1e-6, low=1e-9, high=1e-3,
        ),
        ModelParameter(
            name="ghm_share", meaning="a, share that relaxes", unit="1",
            start=0.2, low=1e-3, high=10.0,
        ),
        ModelParameter(
            name="ghm_rad_per_s", meaning="w", unit="rad/s", start=100.0, low=0.1, high=1e5
        ),
        ModelParameter(
            name="ghm_damping", meaning="z, damping ratio", unit="1", start=3.0, low=0.1, high=1e3
        ),
        ModelParameter(
            name="mu_kg_per_m", meaning="mass per length", unit="kg/m",
            start=5e-3, low=1e-5, high=1.0,
        ),
    ),
    predicts_in_contact=frozenset({"force", "current"}),
    predicts_free=frozenset({"current", "tip", "curve"}),
)  # fmt: skip
