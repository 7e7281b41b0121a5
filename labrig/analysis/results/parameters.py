"""B, E and EIBM of a model with their 90 % intervals, in the units that pages and reports use."""

from __future__ import annotations

from typing import Any

from labrig.analysis.results.models import CandidateModel
from model import Parameter


def parameters_of(model: CandidateModel, configuration: str) -> dict[str, Any]:
    """Return the parameters of one configuration."""
    sheet = model.model.sheets[configuration]
    return {
        "B_uNm2": plain_parameter(sheet.B, 1e6),
        "E_MPa": plain_parameter(sheet.E, 1e-6),
        "EIBM_uNm": {
            str(float(voltage)): plain_parameter(one, 1e6)
            for voltage, one in model.eibm.get(configuration, {}).items()
        },
    }


def plain_parameter(parameter: Parameter, factor: float) -> dict[str, Any]:
    """Return value, sigma and 90 % interval, times a factor."""
    return parameter.scaled(factor, "").to_json()
