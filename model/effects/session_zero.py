"""The load cell's zero is another one in each session."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._values import MILLI
from model.effects.between_sessions import BetweenSessions, one_a_session
from model.effects.interface import EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class SessionZero(BetweenSessions):
    """A force of each session, added to every reading, whether the sheet is touched or not."""

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        added = MILLI * self.change(weighed.session_number, p)
        return np.asarray(np.broadcast_to(added, weighed.force_N.shape).copy())


EFFECT = SessionZero(
    name="session_zero",
    title="zero of the load cell that differs from session to session",
    meaning="The load cell has another zero in each of the sessions analysed together.",
    form="F measured = F + c of the session",
    location="load_cell",
    signature=(
        "The same error of the force at every position and voltage of a session, and another"
        " one in the next; it changes between sessions and not within them."
    ),
    isolates="A zero without contact in each session.",
    source="Doebelin, Measurement Systems: Application and Design (zero drift of a force cell)",
    parameters=one_a_session(
        EffectParameter(
            name="session_1_mN",
            meaning="what the cell shows without a load in session 1",
            unit="mN",
            prior_scale=0.1,
            low=-20.0,
            high=20.0,
        )
    ),
    form_error_along=(),
    of_the_rig=True,
)
