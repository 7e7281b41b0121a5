"""What model files say of the sessions they were fitted to.

Of several model files of one session the library shows one: the newest that `labrig fit` wrote,
which has no effects; only where there is none, the newest that `labrig diagnose` wrote. Of either
kind, one in the session's own folder comes before those in other folders, which may be copies.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, Literal

from labrig.errors import LabrigError
from labrig.model_file import load_model
from model import Along, ConfiguredSheet, ModelError, SheetModel

Kind = Literal["constant", "along_sheet", "effects"]
# without effects, beside the session, time of the last change, name; the highest is shown
Rank = tuple[bool, bool, int, str]
# by configuration: B_Nm2, EIBM_Nm, ... and which file they are from
Fits = dict[str, dict[str, Any]]

# what the EIBM of a model file of each kind is
QUANTITIES: Mapping[Kind, str] = {
    "constant": "constant EIBM",
    "along_sheet": "EIBM along the sheet, mean over [0, l]",
    "effects": "EIBM without the effects, mean over [0, l]",
}
_BEGIN_BYTES = 4096
_MARK = b"labrig_model"


@dataclass(frozen=True)
class ModelFits:
    """One model file: the session it was fitted to, and its parameters by configuration."""

    checksum: str  # of the session
    kind: Kind
    fits: Fits


def looks_like_model(path: Path) -> bool:
    """Whether a TOML file is a model file, by its beginning."""
    try:
        with path.open("rb") as file:
            return _MARK in file.read(_BEGIN_BYTES)
    except OSError:
        return False


def read_fits(path: Path) -> ModelFits | None:
    """Return what a model file holds; None where it cannot be read or names no session."""
    try:
        model = load_model(path)
    except (LabrigError, ModelError):
        return None
    if not model.checksum:
        return None
    kind = _kind(model)
    fits = {name: _fit(model, name, one, kind) for name, one in model.sheets.items()}
    return ModelFits(model.checksum, kind, fits)


def shown_fits(
    session: str, files: Iterable[tuple[str, int, ModelFits]]
) -> dict[str, tuple[Rank, Fits]]:
    """Return the fits to show for a session of this name, by checksum, with their rank.

    `files` are name, time of the last change and content of model files.
    """
    folder = PurePosixPath(session).parent
    best: dict[str, tuple[Rank, Fits]] = {}
    for name, changed, one in files:
        beside = PurePosixPath(name).parent == folder
        rank = (one.kind != "effects", beside, changed, name)
        if one.checksum not in best or best[one.checksum][0] < rank:
            named = {sheet: {**fit, "model": name} for sheet, fit in one.fits.items()}
            best[one.checksum] = (rank, named)
    return best


def _kind(model: SheetModel) -> Kind:
    if model.effects:
        return "effects"
    nodes = (len(along.s_m) for one in model.sheets.values() for along in one.eibm.values())
    return "along_sheet" if max(nodes, default=1) > 1 else "constant"


def _fit(model: SheetModel, name: str, one: ConfiguredSheet, kind: Kind) -> dict[str, Any]:
    own = model.own_merit.get(name, {})
    return {
        "B_Nm2": one.B.value,
        "B_sigma": one.B.sigma,
        "E_Pa": one.E.value,
        "EIBM_Nm": {str(float(v)): one.mean_eibm(v) for v in sorted(one.eibm)},
        "EIBM_sigma": {str(float(v)): _sigma(along) for v, along in sorted(one.eibm.items())},
        "EIBM_quantity": QUANTITIES[kind],
        "kind": kind,
        # of this configuration; files of older versions state those of all together only
        "rmse_force_mN": _milli(own.get("force_rmse_N")),
        "rmse_curve_mm": _milli(own.get("curve_rmse_m")),
        "rmse_all_force_mN": _milli(model.merit.get("force_rmse_N")),
        "rmse_all_curve_mm": _milli(model.merit.get("curve_rmse_m")),
    }


def _sigma(along: Along) -> float | None:
    """Of a constant EIBM; that of a mean along the sheet is not in the file."""
    return float(along.sigma[0]) if len(along.sigma) == 1 else None


def _milli(value: float | None) -> float | None:
    return None if value is None else 1e3 * value
