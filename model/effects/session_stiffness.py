"""The sheet's stiffness is another one in each session."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.between_sessions import BetweenSessions, one_a_session
from model.effects.interface import BeamProblem, ContactSolution, EffectParameter, Values

LEAST = 0.05  # of the mean of the sessions


@dataclass(frozen=True, kw_only=True)
class SessionStiffness(BetweenSessions):
    """B of each session; the EIBM is the same, and bends the sheet less where B is larger."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        factor = np.maximum(1.0 + self.change(beam.session_number, p), LEAST)
        stiffness = beam.stiffness * factor
        return replace(beam, stiffness=stiffness, eibm=beam.eibm / np.reshape(factor, (-1, 1)))


EFFECT = SessionStiffness(
    name="session_stiffness",
    title="stiffness that differs from session to session",
    meaning=(
        "The sheet is stiffer or softer in one of the sessions analysed together: it was"
        " swollen more or less, or aged in between."
    ),
    form="B = mean of the sessions x (1 + c of the session)",
    location="compliance",
    signature=(
        "At 0 V all forces of a session are larger by the same share than those of another"
        " session, and its shapes are the same."
    ),
    isolates="A position measured again in each session, at 0 V.",
    source=(
        "Nemat-Nasser and Thomas 2004, in Bar-Cohen (ed.), Electroactive Polymer Actuators, 2nd"
        " ed., ch. 6 (stiffness against hydration)"
    ),
    parameters=one_a_session(
        EffectParameter(
            name="session_2",
            meaning="stiffness in session 2 less that in session 1, over their mean",
            unit="",
            prior_scale=0.1,
            low=-0.7,
            high=1.5,
        )
    ),
    form_error_along=("voltage",),
    from_first=True,
)
