"""The image is older than the reading."""

from __future__ import annotations

from dataclasses import dataclass

from model.effects.interface import AcquisitionTimes, Effect, EffectParameter, Values
from model.effects.rise import older_picture, through_zero
from model.measurements import FloatArray


@dataclass(frozen=True)
class FrameDelay(Effect):
    """Every frame shows the sheet as it was a while ago."""

    def in_image(self, clock: AcquisitionTimes, p: Values) -> FloatArray:
        """See `Effect.in_image`."""
        return older_picture(
            through_zero(clock) if p["through_zero"] > 0.5 else clock, p["delay_s"]
        )


EFFECT = FrameDelay(
    name="frame_delay",
    meaning="The picture shows the sheet as it was some time before the force was read.",
    form="curve at t = shape at t - c",
    location="camera",
    signature=(
        "Shapes under voltage that have not come quite as far as the forces say, the less so the"
        " longer the voltage has been on; those at 0 V are right."
    ),
    isolates="A lamp in the picture switched with the voltage; frames over the whole pulse.",
    source="the paper, section 3.1: 25 frames a second, so that a frame may be 20 ms off",
    parameters=(
        EffectParameter(
            name="delay_s",
            meaning="age of the picture at the time of the reading",
            unit="s",
            prior_scale=0.1,
            low=-0.2,
            high=1.0,
            starting_values=(0.02, 0.1, 0.2, 0.3, 0.35, 0.4, 0.43, 0.46),
        ),
        EffectParameter(
            name="through_zero",
            meaning="0: the EIBM goes straight from one settled value to the other; 1: it"
            " follows the voltage through 0, each polarity at its own slope",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
    ),
    explained_by_dynamics=True,
    form_error_along=("time", "run"),
    of_the_rig=True,
)
