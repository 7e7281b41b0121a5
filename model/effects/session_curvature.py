"""The sheet is bent at rest by another curvature in each session."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.between_sessions import BetweenSessions, one_a_session
from model.effects.interface import BeamProblem, ContactSolution, EffectParameter, Values


@dataclass(frozen=True, kw_only=True)
class SessionCurvature(BetweenSessions):
    """A curvature at rest that is added in each session, the same along the sheet."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        added = np.reshape(self.change(beam.session_number, p), (-1, 1))
        return replace(beam, rest=beam.rest + added)


EFFECT = SessionCurvature(
    name="session_curvature",
    title="rest curvature that differs from session to session",
    meaning=(
        "The sheet at rest is more curved in one of the sessions analysed together: it crept,"
        " or was clamped anew, in between."
    ),
    form="k0 = mean of the sessions + c of the session",
    location="rest_curvature",
    signature=(
        "All shapes of a session are bent more, at all voltages alike, and its forces are shifted."
    ),
    isolates="A free shape at 0 V in each session.",
    source="the paper, section 3.1: the initial curvature is measured before each experiment",
    parameters=one_a_session(
        EffectParameter(
            name="session_2_per_m",
            meaning="curvature at rest in session 2 less that in session 1",
            unit="1/m",
            prior_scale=1.0,
            low=-60.0,
            high=60.0,
        )
    ),
    form_error_along=("s",),
    from_first=True,
    by_configuration=True,
)
