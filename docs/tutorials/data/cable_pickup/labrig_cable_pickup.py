"""The drive couples into the load cell's cable."""

from dataclasses import dataclass

import numpy as np

from model.effects import Effect, EffectParameter


@dataclass(frozen=True)
class CablePickup(Effect):
    """A force that is proportional to the height above 15 mm on the arc, without contact too."""

    def force(self, weighed, p):
        """Return what is added to each reading, N."""
        position_m = np.nan_to_num(weighed.position_m)  # NaN without contact
        return 1e-3 * p["force_mN"] * np.tanh((position_m - 0.015) / 0.005)


EFFECT = CablePickup(
    name="cable_pickup",
    meaning="The load cell's cable picks up more where it comes near the amplifier.",
    form="F measured = F + c tanh((p - 15 mm)/5 mm)",
    location="load_cell",
    signature="An error of the force that changes sign in the middle of the arc.",
    isolates="The same positions with the cable laid another way.",
    source="Doebelin, Measurement Systems: Application and Design (capacitive pickup)",
    parameters=(
        EffectParameter(
            name="force_mN",
            meaning="far from the middle",
            unit="mN",
            prior_scale=0.05,
            low=-20.0,
            high=20.0,
        ),
    ),
    form_error_along=("position",),
)
