"""What a simulation returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from model.measurements import Displayed, FloatArray, Summary, dataframe

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, kw_only=True, repr=False)
class SheetMotion(Displayed):
    """What was computed at T times and S points; NaN after the sheet has slipped out."""

    time_s: FloatArray  # (T,)
    drive_V: FloatArray  # of the source; at an edge the voltage before it
    sheet_V: FloatArray  # between the electrodes at the clamp
    current_A: FloatArray
    force_N: FloatArray  # F of the sheet on the rolls along the arc's tangent; 0 where it is free
    reading_N: FloatArray  # the same as the load cell follows it
    normal_N: FloatArray  # N
    s_hat_m: FloatArray  # NaN where the sheet is free
    phi_hat_rad: FloatArray
    s_m: FloatArray  # (S,)
    x_m: FloatArray  # (T, S)
    y_m: FloatArray
    phi_rad: FloatArray
    curvature_per_m: FloatArray
    slipped_s: float | None = None  # when the sheet left the rolls

    def summary(self) -> Summary:
        """Return the range of each quantity over time."""
        rows = []
        for name, values in self._over_time().items():
            known = values[np.isfinite(values)]
            if len(known):
                span = (f"{known.min():.4g}", f"{known.max():.4g}", f"{known[-1]:.4g}")
                rows.append((name, *span))
        slipped = () if self.slipped_s is None else (f"slips out at {self.slipped_s:.3f} s",)
        length = f"{len(self.time_s)} times, {len(self.s_m)} points of the shape"
        columns = ("quantity", "least", "most", "last")
        return Summary(f"SheetMotion: {length}", columns, rows, slipped)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each time as a pandas data frame, in SI units; the shape as its tip."""
        return dataframe(self._over_time())

    def _over_time(self) -> dict[str, FloatArray]:
        names = (
            "time_s", "drive_V", "sheet_V", "current_A", "force_N", "reading_N", "normal_N",
            "s_hat_m", "phi_hat_rad",
        )  # fmt: skip
        tip = {f"tip_{name}": getattr(self, name)[:, -1] for name in ("x_m", "y_m", "phi_rad")}
        return {**{name: getattr(self, name) for name in names}, **tip}
