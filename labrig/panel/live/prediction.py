"""What a model predicts under the conditions of an image, and by how much it misses the curve."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from labrig.errors import LabrigError
from labrig.model_file import load_model
from labrig.panel.live.event_stream import Message
from labrig.vision import NeutralCurve, Optics
from model import ModelError, SheetModel, predict, predict_free

Floats = npt.NDArray[np.float64]

MOST_POINTS = 150  # of a line that is drawn
_PX_DECIMALS = 2


def thinned(points: Floats) -> Floats:
    """Return at most about `MOST_POINTS` of these, the first one included."""
    return points[:: max(1, len(points) // MOST_POINTS)]


def rounded_px(points: Floats) -> list[list[float]]:
    """Return pixels as they are sent."""
    found: list[list[float]] = np.round(points, _PX_DECIMALS).tolist()
    return found


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Under which an image was acquired."""

    configuration: str
    position_mm: float | None
    voltage_V: float


@dataclass(frozen=True, kw_only=True)
class PredictedErrors:
    """Curve (n, 2) in m and force; empty and None where there is none, and why."""

    points_m: Floats
    force_mN: float | None
    why: str


class Predictions:
    """Of one model; each condition is computed once."""

    def __init__(self, path: str | None) -> None:
        """Read a model file; a fault in it is what each prediction says."""
        self._model: SheetModel | None = None
        self._fault = ""
        self._known: dict[Conditions, PredictedErrors] = {}
        if path is not None:
            try:
                self._model = load_model(Path(path))
            except LabrigError as error:
                self._fault = str(error)

    def at(self, conditions: Conditions) -> PredictedErrors | None:
        """Return the prediction; None when no model was chosen."""
        if self._fault:
            return PredictedErrors(points_m=np.empty((0, 2)), force_mN=None, why=self._fault)
        if self._model is None:
            return None
        if conditions not in self._known:
            self._known[conditions] = _predicted(self._model, conditions)
        return self._known[conditions]


def _predicted(model: SheetModel, conditions: Conditions) -> PredictedErrors:
    name, volts = conditions.configuration, conditions.voltage_V
    force_mN, why = None, ""
    try:
        if conditions.position_mm is None:
            _, x_m, y_m = predict_free(model, name, volts)
        else:
            found = predict(model, name, conditions.position_mm / 1000, volts)
            x_m, y_m, why = found.x_m, found.y_m, found.why
            force_mN = 1e3 * found.F_N if found.reachable else None
    except ModelError as error:
        x_m = y_m = np.empty(0)
        why = f"{error}."
    return PredictedErrors(points_m=np.column_stack([x_m, y_m]), force_mN=force_mN, why=why)


def prediction_message(
    predicted: PredictedErrors,
    found: NeutralCurve,
    optics: Optics,
    *,
    voltage_V: float,
    measured_mN: float | None,
) -> Message:
    """Return the prediction as pages see it. Errors are prediction minus measurement."""
    distance_mm = None
    if found.ok and len(predicted.points_m) > 1:
        seen = thinned(np.column_stack([found.x_m, found.y_m]))
        distance_mm = round(1e3 * rms_distance(seen, predicted.points_m), 4)
    error_mN = None
    if predicted.force_mN is not None and measured_mN is not None:
        error_mN = round(predicted.force_mN - measured_mN, 4)
    points = thinned(optics.world_to_pixel(predicted.points_m))
    return {
        "points_px": rounded_px(points),
        "voltage_V": voltage_V,
        "force_mN": predicted.force_mN,
        "why": predicted.why,
        "distance_mm": distance_mm,
        "force_error_mN": error_mN,
    }


def rms_distance(points: Floats, line: Floats) -> float:
    """Return the RMS distance of points (n, 2) from a polyline (m, 2), in their own unit."""
    begin, along = line[:-1], np.diff(line, axis=0)
    apart = points[:, None, :] - begin[None]
    length2 = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip((apart * along).sum(axis=2) / length2, 0.0, 1.0)
    nearest2 = ((apart - share[:, :, None] * along) ** 2).sum(axis=2).min(axis=1)
    return float(np.sqrt(nearest2.mean()))
