"""Free shapes that are still moving."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.identification.data.swinging_shapes import swings_m
from model.measurements import Measurements, in_volts


@dataclass(frozen=True)
class Swinging(DataCheck):
    """The end of a sheet that nothing touches is elsewhere in each picture."""

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        found = swings_m(measurements)
        for name in dict.fromkeys(name for name, _ in found):
            moving = {volts: size for (other, volts), size in found.items() if other == name}
            volts = max(moving, key=lambda v: moving[v])
            yield Suspicion(
                check=self.name, severity="warn", where="curves.csv, free shapes",
                configurations=(name,), value=1e3 * moving[volts], unit="mm",
                sentence=(
                    f"the end of '{name}' without contact moves by {1e3 * moving[volts]:.2g} mm"
                    f" (RMS, at {in_volts(volts)}) from picture to picture: it may still swing;"
                    " wait longer before free shapes, or give a model with dynamics"
                ),
            )  # fmt: skip


CHECK = Swinging(name="swinging", meaning="the free shapes against each other", order=4)
