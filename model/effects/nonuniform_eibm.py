"""EIBM that falls along the sheet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values
from model.measurements import FloatArray, SheetGeometry


@dataclass(frozen=True)
class NonuniformEibm(Effect):
    """exp(-s/lambda) over its mean: the mean EIBM along the free length stays what it was.

    The free length is the measured one: a sheet that is cut keeps the EIBM of each place.
    """

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        decay_m = p["decay_length_mm"] * 1e-3
        share = falling(beam.material_m, decay_m, beam.material_length_m)
        return replace(beam, eibm=beam.eibm * share)

    def derived(self, p: Values, sheet: SheetGeometry) -> dict[str, float]:
        """See `Effect.derived`."""
        fall = sheet.free_length_m / (p["decay_length_mm"] * 1e-3)
        return {"end_to_root_ratio": float(np.exp(-fall))}


def falling(s_m: FloatArray, decay_m: float, length_m: float) -> FloatArray:
    """exp(-s/lambda) over its mean along [0, l]."""
    fall = length_m / decay_m
    if fall < 1e-9:  # the next term would be lost in rounding
        return np.ones_like(s_m)
    shape: FloatArray = np.exp(-s_m / decay_m) * (fall / -np.expm1(-fall))
    return shape


EFFECT = NonuniformEibm(
    name="nonuniform_eibm",
    title="EIBM along the sheet",
    meaning=(
        "The EIBM falls from the clamp to the end of the sheet, because the resistance of the thin"
        " electrodes leaves less voltage across the sheet farther from the contacts."
    ),
    form="Me(s) = mean x exp(-s/lambda) over its mean along the free length",
    location="eibm",
    signature=(
        "Under voltage the sheet bends more near the clamp and less near its end than a constant"
        " EIBM would have it, the more the longer the sheet; nothing at 0 V."
    ),
    isolates="Free shapes under voltage, or curves at half the voltage: the fall is proportional.",
    source=(
        "Shahinpoor and Kim 2000, Smart Mater. Struct. 9, 543; Punning, Kruusmaa and Aabloo 2006,"
        " Sensors and Actuators A 133, 200"
    ),
    parameters=(
        EffectParameter(
            name="decay_length_mm",
            meaning="length over which the EIBM falls to 1/e",
            unit="mm",
            prior_scale=30.0,
            low=3.0,
            high=1000.0,
            neutral=np.inf,
            log=True,
            starting_values=(5, 8, 12, 20, 35, 60, 120, 250),
        ),
    ),
    explained_by_dynamics=True,
    form_error_along=("s", "voltage"),
    extra={"end_to_root_ratio": ""},
)
