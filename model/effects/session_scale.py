"""The image has another scale in each session."""

from __future__ import annotations

from dataclasses import dataclass

from model.effects.between_sessions import BetweenSessions, one_a_session
from model.effects.interface import EffectParameter, ImagePoints, Values
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class SessionScale(BetweenSessions):
    """All points of a session farther from the clamp by the same share."""

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.curve`."""
        error = self.change(points.session_number, p)
        return error * points.x_m, error * points.y_m


EFFECT = SessionScale(
    name="session_scale",
    title="camera scale that differs from session to session",
    meaning=(
        "Lengths in the picture come out too long by a share that is another one in each of the"
        " sessions analysed together."
    ),
    form="r seen = (1 + c of the session) r, from the clamp",
    location="camera",
    signature=(
        "Curves of a session that are everywhere too large by the same share; the forces are right."
    ),
    isolates="A target of known length in view, in each session.",
    source="Hartley and Zisserman 2004, Multiple View Geometry in Computer Vision, ch. 6",
    parameters=one_a_session(
        EffectParameter(
            name="session_1",
            meaning="length seen over true length, less 1, in session 1",
            unit="",
            prior_scale=0.01,
            low=-0.5,
            high=0.5,
        )
    ),
    form_error_along=(),
    of_the_rig=True,
    moves_along_sheet=True,
)
