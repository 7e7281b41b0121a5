"""The EIBM is another one in each session."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.between_sessions import BetweenSessions, one_a_session
from model.effects.interface import BeamProblem, ContactSolution, EffectParameter, Values

LEAST = 0.05  # of the mean of the sessions


@dataclass(frozen=True, kw_only=True)
class SessionEibm(BetweenSessions):
    """Me of each session, at all voltages alike."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        factor = np.maximum(1.0 + self.change(beam.session_number, p), LEAST)
        return replace(beam, eibm=beam.eibm * np.reshape(factor, (-1, 1)))


EFFECT = SessionEibm(
    name="session_eibm",
    title="EIBM that differs from session to session",
    meaning=(
        "The voltage bends the sheet more in one of the sessions analysed together than in another."
    ),
    form="Me = mean of the sessions x (1 + c of the session)",
    location="eibm",
    signature=(
        "What the voltage does to force and shape is larger by the same share at all positions"
        " of a session; readings at 0 V are the same in all."
    ),
    isolates="A position measured again in each session.",
    source=(
        "Nemat-Nasser and Thomas 2004, in Bar-Cohen (ed.), Electroactive Polymer Actuators, 2nd"
        " ed., ch. 6 (response against hydration)"
    ),
    parameters=one_a_session(
        EffectParameter(
            name="session_2",
            meaning="EIBM in session 2 less that in session 1, over their mean",
            unit="",
            prior_scale=0.1,
            low=-0.9,
            high=2.0,
        )
    ),
    form_error_along=("voltage",),
    from_first=True,
)
