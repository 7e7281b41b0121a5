"""The errors of a result: where model and measurements disagree, and by how much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from model.discrepancy.verdict.result.json_numbers import json_number
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class Where:
    """A cell in which simulation and measurement disagree."""

    observable: Literal["force", "curve", "signal"]
    configuration: str
    voltage_V: float
    position_mm: float | None
    s_mm: float | None
    z: float
    detail: str = ""  # reading or time, where it is that

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        result: dict[str, Any] = {
            "observable": self.observable, "configuration": self.configuration,
            "voltage_V": self.voltage_V, "position_mm": self.position_mm, "s_mm": self.s_mm,
            "z": round(self.z, 2),
        }  # fmt: skip
        if self.detail:
            result["detail"] = self.detail
        return result


@dataclass(frozen=True, kw_only=True)
class Gap:
    """How far a model is from the measurements: mean forces, curves, and both in time."""

    force_rmse_mN: float
    curve_rmse_mm: float
    chi2_per_dof: float  # of mean forces and curves
    drift_rmse_mN: float = float("nan")  # how a condition's readings go along the run
    pulse_rmse_mN: float = float("nan")  # parts of a pulse against its sampling point
    drift_rmse_mm: float = float("nan")  # how far out the readings' curves are, along the run

    def to_json(self) -> dict[str, float | None]:
        """Return the numbers; what does not exist is null."""
        return {k: json_number(v) for k, v in self.__dict__.items()}


@dataclass(frozen=True)
class BeforeAfter:
    """The base model, and the model with the effects found."""

    before: Gap
    after: Gap

    def to_json(self) -> dict[str, Any]:
        """Both."""
        return {"before": self.before.to_json(), "after": self.after.to_json()}


@dataclass(frozen=True, kw_only=True)
class ClosedGap:
    """How much of a prediction error on left-out positions is closed, above the noise floor."""

    share: float  # 1 - (after^2 - floor^2)/(before^2 - floor^2)
    quantity: str  # whose error it is: that which stands out of the noise most
    before: float  # RMS, in `unit`
    after: float
    floor: float  # RMS that noise and scatter alone cause
    unit: str

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "share": round(self.share, 4), "quantity": self.quantity, "before": self.before,
            "after": self.after, "floor": self.floor, "unit": self.unit,
        }  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ErrorRow:
    """One condition, measured and simulated; curves in metres, at the measured points."""

    configuration: str
    position_m: float | None
    voltage_V: float
    force_N: float
    sigma_N: float  # of the mean force, all noise and scatter included
    before_N: float
    after_N: float
    s_m: FloatArray
    x_m: FloatArray
    y_m: FloatArray
    before_xy_m: tuple[FloatArray, FloatArray]
    after_xy_m: tuple[FloatArray, FloatArray]
    before_off_m: FloatArray  # distance measured - simulated along the normal
    after_off_m: FloatArray
    held_out_before_N: float = float("nan")
    held_out_after_N: float = float("nan")
    # the models at the most likely offsets of the condition's set-up; not known of older diagnoses
    before_at_setup_N: float = float("nan")
    after_at_setup_N: float = float("nan")
    before_at_setup_xy_m: tuple[FloatArray, FloatArray] | None = None
    after_at_setup_xy_m: tuple[FloatArray, FloatArray] | None = None
