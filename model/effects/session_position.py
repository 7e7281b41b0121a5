"""The positions are off by another length in each session."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects._values import MILLI
from model.effects.between_sessions import BetweenSessions, one_a_session
from model.effects.interface import BeamProblem, ContactSolution, EffectParameter, Values


@dataclass(frozen=True, kw_only=True)
class SessionPosition(BetweenSessions):
    """All contacts of a session farther along the arc by the same length."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        shift_m = MILLI * self.change(beam.session_number, p)
        return replace(beam, shift_m=beam.shift_m + shift_m)


EFFECT = SessionPosition(
    name="session_position",
    title="position error that differs from session to session",
    meaning=(
        "The load cell stands farther along the arc than stated, by another length in each of"
        " the sessions analysed together."
    ),
    form="p = stated p + c of the session",
    location="position",
    signature=(
        "The held shapes of a session are turned at the contact alike at all voltages, and its"
        " force is shifted by its slope times the error."
    ),
    isolates="The contact's place in the picture, in each session.",
    source="the paper, section 3.1: the load cell is repositioned by hand between experiments",
    parameters=one_a_session(
        EffectParameter(
            name="session_1_mm",
            meaning="true less stated position along the arc in session 1",
            unit="mm",
            prior_scale=0.3,
            low=-10.0,
            high=10.0,
        )
    ),
    form_error_along=(),
    of_the_rig=True,
)
