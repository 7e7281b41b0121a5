"""The sheet at rest is curved otherwise than sheet.toml says."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects.interface import Beam, Effect, Held, Knob, Values


@dataclass(frozen=True)
class InitialCurvature(Effect):
    """A change of k0, the same from the clamp to the end."""

    def beam(self, beam: Beam, held: Held, p: Values) -> Beam:
        """See `Effect.beam`."""
        del held
        return replace(beam, rest=beam.rest + p["curvature_error_per_m"])


EFFECT = InitialCurvature(
    name="initial_curvature",
    meaning=(
        "The sheet at rest is more curved than stated, in the direction of positive deflection."
    ),
    form="k0(s) = stated k0(s) + c",
    slot="rest_curvature",
    signature=(
        "The same turn of the free shape at every voltage, 0 V too, and with it a force that is"
        " shifted alike at all voltages."
    ),
    isolates="A free shape at 0 V, with no load cell near the sheet.",
    source="the paper, table 3: the sheets have an initial curvature, measured once per sheet",
    knobs=(
        Knob(
            "curvature_error_per_m", "curvature at rest less that stated", "1/m", 1.0,
            low=-60.0, high=60.0,
        ),
    ),
    tolerance=("s",),
    waves=7,
    by_configuration=True,
)  # fmt: skip
