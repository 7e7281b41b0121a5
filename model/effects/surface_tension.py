"""Water between sheet and rolls pulls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import Effect, EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class SurfaceTension(Effect):
    """A constant force along the sheet's normal while it is touched.

    The meniscus spans the gap between sheet and roll, so that it pulls across the sheet, and turns
    with it.
    """

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        seen = weighed.touching * np.cos(weighed.gamma_rad)
        left = np.exp(-weighed.wetted_s / p["dries_s"]) if p["dries_s"] > 0.0 else 1.0
        return np.where(weighed.touching > 0.0, p["force_mN"] * MILLI * left * seen, 0.0)


EFFECT = SurfaceTension(
    name="surface_tension",
    meaning=(
        "A meniscus between the wet sheet and one of the rolls pulls the load cell along the"
        " sheet's normal, in the positive direction where the force is positive."
    ),
    form=(
        "F measured = F + c cos(gamma) while the sheet is touched; or c exp(-t/tau), t since the"
        " last wetting"
    ),
    location="load_cell",
    signature=(
        "As a wrong zero, but each sheet has its own, most likely the short one, in whose rolls the"
        " water stays; not in readings without contact, and smaller where the sheet leans."
    ),
    isolates="A zero taken without touching the sheet beside one taken just as it touches.",
    source=(
        "de Gennes, Brochard-Wyart and Quéré 2004, Capillarity and Wetting Phenomena; the paper,"
        " section 4.2, observation 1"
    ),
    parameters=(
        EffectParameter(
            name="force_mN",
            meaning="pull along the sheet's normal",
            unit="mN",
            prior_scale=0.1,
            low=-5.0,
            high=5.0,
            one_sign=True,
            instrument_limit=2.0,
            beyond="a meniscus as wide as the sheet cannot pull with {value} mN",
        ),
        EffectParameter(
            name="dries_s",
            meaning="time constant with which the water goes; 0: it stays",
            unit="s",
            prior_scale=0.0,
            low=0.0,
            high=1e4,
            starting_values=(0.0, 15.0, 60.0),
        ),
    ),
    form_error_along=("position", "voltage", "wetted"),
    by_configuration=True,
)
