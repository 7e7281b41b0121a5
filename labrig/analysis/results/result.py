"""Put the result of a session together."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from labrig.analysis.results.convergence import Convergence
from labrig.analysis.results.measured import condition_of, mean_force_of, sheet_of
from labrig.analysis.results.models import CandidateModel, models_of
from labrig.analysis.results.parameters import parameters_of
from labrig.analysis.results.predicted import Predicted, predicted_by
from model import Fit, Measurements, SheetModel

FORMAT = 1


def result_of(
    measurements: Measurements,
    *,
    session: str = "",
    fitted: Fit | None = None,
    with_effects: SheetModel | None = None,
    convergence: Convergence | None = None,
    diagnosis: Mapping[str, Any] | None = None,
    missing: list[dict[str, Any]] | None = None,
    out_of_date: list[str] | None = None,
) -> dict[str, Any]:
    """Return what a page draws: plain data for JSON, in mm, mN, uN m^2 and uN m; unknown is null.

    `fitted`: of these measurements; without it there are no models and no parameters.
    `with_effects`: what the diagnosis found (NAME.model+.toml). `convergence`: of `converging`.
    `diagnosis`, `missing` and `out_of_date` are sentences of the caller, handed on as they are.

        {
          "format": 1, "session": NAME, "checksum": "...", "warnings": ["..."],
          "missing": [{"text": "...", "kind": "analyze"|"fit"|"diagnose"|"report"|"next"}],
          "out_of_date": ["The model file ... was fitted to other data."],
          "models": [{"id": "constant"|"along"|"effects", "name": "constant EIBM", "why": "..."}],
          "configurations": [{
            "name": "long",
            "sheet": {"free_length_mm", "elongation_mm", "arc_radius_mm", "arc_origin_deg"},
            "positions_mm": [0.0, ...], "voltages_V": [2.0, 0.0, -2.0],
            "conditions": [{
              "id": 0,                              # its place among the measurements' conditions
              "position_mm": 5.0|null, "voltage_V": 2.0, "mounting": 0, "run": 0, "approach": "",
              "force": {"mean_mN", "sigma_mN"|null, "deviation_mN"|null, "readings"}|null,
              "curve": CURVE|null,                  # of the mean image
              "contact": {"x_mm", "y_mm"}|null,
              "readings": [{"index", "kind", "time_s"|null, "force_mN", "valid", "why", "curve"}],
              "models": {ID: {"force_mN", "force90_mN": [low, high], "curve": CURVE|null, "why"}}
            }],
            "lines": [{"model": ID, "voltage_V", "p_mm": [], "F_mN": [], "half90_mN": []}],
            "parameters": {ID: {"B_uNm2": PARAMETER, "E_MPa": PARAMETER,
                                "EIBM_uNm": {"2.0": PARAMETER}}}
          }],
          "convergence": {"long": [{"positions": 3, "position_mm": 10.0|null, "conditions": 9,
                                    "B_uNm2": PARAMETER|null, "EIBM_uNm": {"2.0": PARAMETER},
                                    "why": "..."}]},
          "diagnosis": {"verdict", "title", "sentences": ["..."], "next": ["..."]}|null
        }

    CURVE: {"x_mm": [], "y_mm": [], "half90_mm": []|null}, the half width of the 90 % band along the
    normal. A measured curve's band is its own uncertainty. Bands of models hold 90 % of what new
    set-ups would measure. "curve" of a reading says whether there is one; see `reading_curve`.
    PARAMETER: {"value", "sigma", "interval90": [low, high]}.
    """
    models = models_of(fitted, with_effects)
    predicted = {model.id: predicted_by(model, measurements) for model in models}
    return {
        "format": FORMAT,
        "session": session,
        "checksum": measurements.checksum,
        "warnings": list(measurements.warnings),
        "missing": list(missing or ()),
        "out_of_date": list(out_of_date or ()),
        "models": [{"id": one.id, "name": one.name, "why": one.why} for one in models],
        "configurations": [
            _configuration(measurements, name, models, predicted) for name in _names(measurements)
        ],
        "convergence": convergence or {},
        "diagnosis": None if diagnosis is None else dict(diagnosis),
    }


def _names(measurements: Measurements) -> list[str]:
    """Return the configurations that were measured, in the order of sheet.toml."""
    measured = {condition.configuration for condition in measurements.conditions}
    return [name for name in measurements.sheets if name in measured]


def _configuration(
    measurements: Measurements,
    name: str,
    models: list[CandidateModel],
    predicted: Mapping[str, Predicted],
) -> dict[str, Any]:
    own = [(i, c) for i, c in enumerate(measurements.conditions) if c.configuration == name]
    places_mm = {round(1e3 * c.position_m, 6) for _, c in own if c.position_m is not None}
    conditions = []
    for i, condition in own:
        one = condition_of(i, condition)
        one["force"] = mean_force_of(condition)
        one["models"] = {
            key: found.conditions[i] for key, found in predicted.items() if i in found.conditions
        }
        conditions.append(one)
    return {
        "name": name,
        "sheet": sheet_of(measurements.sheets[name]),
        "positions_mm": sorted(places_mm),
        "voltages_V": sorted({c.voltage_V for _, c in own}, reverse=True),
        "conditions": conditions,
        "lines": [line for found in predicted.values() for line in found.lines.get(name, ())],
        "parameters": {
            model.id: parameters_of(model, name) for model in models if name in model.model.sheets
        },
    }
