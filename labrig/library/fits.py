"""What model files say of the sessions they were fitted to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from labrig.errors import LabrigError
from labrig.library.entry import Fits
from labrig.model_file import load_model
from model import Along, ConfiguredSheet, ModelError, SheetModel

_BEGIN_BYTES = 4096
_MARK = b"labrig_model"


def looks_like_model(path: Path) -> bool:
    """Whether a TOML file is a model file, by its beginning."""
    try:
        with path.open("rb") as file:
            return _MARK in file.read(_BEGIN_BYTES)
    except OSError:
        return False


def read_fits(path: Path) -> tuple[str, Fits] | None:
    """Return the checksum of the session a model was fitted to, and its parameters, or None."""
    try:
        model = load_model(path)
    except (LabrigError, ModelError):
        return None
    if not model.checksum:
        return None
    return model.checksum, {name: _fit(model, one) for name, one in model.sheets.items()}


def _fit(model: SheetModel, one: ConfiguredSheet) -> dict[str, Any]:
    return {
        "B_Nm2": one.B.value,
        "B_sigma": one.B.sigma,
        "E_Pa": one.E.value,
        "EIBM_Nm": {str(float(v)): one.mean_eibm(v) for v in sorted(one.eibm)},
        "EIBM_sigma": {str(float(v)): _sigma(along) for v, along in sorted(one.eibm.items())},
        "rmse_force_mN": _milli(model.merit.get("force_rmse_N")),
        "rmse_curve_mm": _milli(model.merit.get("curve_rmse_m")),
    }


def _sigma(along: Along) -> float | None:
    """Of a constant EIBM; that of a mean along the sheet is not in the file."""
    return float(along.sigma[0]) if len(along.sigma) == 1 else None


def _milli(value: float | None) -> float | None:
    return None if value is None else 1e3 * value
