"""EIBMs of one's own: as numbers, functions, arrays or tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from labrig.api.data import number
from labrig.errors import BadInputError
from model.measurements import FloatArray, ModelError
from model.sheet.sheet_model import SheetModel
from model.sheet.stated import StatedEibm, with_eibm

# Me in N m: a number, a function of s_m, or (s_m, Me_Nm) with straight lines between the nodes
Eibm = float | Callable[[FloatArray], FloatArray] | tuple[Sequence[float], Sequence[float]]
LONGEST_RATIO = 10.0  # of the last place of a stated EIBM to the sheet's length
NODES = 51  # at which a function is taken, along the longest sheet; as of a fit
_EXAMPLE = "--eibm 2=36e-6 (N m), or --eibm 2=eibm.csv (columns s_mm, Me_Nm)"


def model_with_eibm(model: SheetModel, eibm: Mapping[float, Eibm] | None) -> SheetModel:
    """Return a model with the EIBM of some voltages replaced; raises ModelError."""
    voltages_of(eibm)
    if not eibm:
        return model
    length_m = max((one.sheet.free_length_m for one in model.sheets.values()), default=0.0)
    return with_eibm(model, {float(v): stated(v, one, length_m) for v, one in eibm.items()})


def voltages_of(eibm: Mapping[float, Eibm] | None) -> list[float]:
    """Return the voltages of EIBMs. Raises BadInputError where they are not given by voltage."""
    if not isinstance(eibm, Mapping | None):  # a caller may give anything
        raise BadInputError(
            f"--eibm {eibm!r}: EIBMs by voltage are needed, such as {{2.0: 36e-6}}."
        )
    return [number("--eibm", voltage_V) for voltage_V in eibm or ()]


def stated(voltage_V: float, eibm: Eibm, length_m: float) -> StatedEibm:
    """Return an EIBM as the model takes it; a function is taken from 0 to `length_m`."""
    try:
        if callable(eibm):
            s_m = np.linspace(0.0, length_m, NODES)
            return s_m, np.broadcast_to(np.asarray(eibm(s_m), dtype=np.float64), s_m.shape)
        if not isinstance(eibm, tuple):
            return float(eibm)
        s_m, values = (np.asarray(part, dtype=np.float64) for part in eibm)
    except (TypeError, ValueError):
        raise ModelError(
            f"the EIBM at {voltage_V:+g} V must be a number in N m, a function of s_m, or a pair"
            " (s_m, Me_Nm) of equally long rows"
        ) from None
    _require_along_the_sheet(voltage_V, s_m, length_m)
    return s_m, values


def _require_along_the_sheet(voltage_V: float, s_m: FloatArray, length_m: float) -> None:
    """Raise ModelError for places in another unit: all of the sheet would have the first value."""
    end_m = float(np.max(s_m, initial=0.0))
    if length_m and end_m > LONGEST_RATIO * length_m:
        raise ModelError(
            f"the EIBM stated at {voltage_V:+g} V reaches to s = {end_m:g} m, the sheet to"
            f" {length_m:g} m; its places s are in m (s_mm of a table in mm)"
        )


def parsed_eibm(texts: Sequence[str]) -> dict[float, Eibm]:
    """Return what the command line states: VOLTAGE=NUMBER or VOLTAGE=FILE.csv each."""
    found: dict[float, Eibm] = {}
    for text in texts:
        volts, equals, value = text.partition("=")
        voltage_V = _number(volts)
        if not equals or voltage_V is None or not value:
            raise BadInputError(f"--eibm {text!r}: write {_EXAMPLE}.")
        if voltage_V in found:
            raise BadInputError(f"--eibm {text!r}: the EIBM at {voltage_V:+g} V is given twice.")
        number = _number(value)
        found[voltage_V] = _table(Path(value)) if number is None else number
    return found


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _table(path: Path) -> Eibm:
    """Return places and values of a table."""
    from labrig.session.tables.decimals import from_plain
    from labrig.session.tables.table import read_table
    from labrig.session.tables.text.meaning import ExpectedColumns

    expected = ExpectedColumns(kind="eibm", required=("s_mm", "Me_Nm"), renamed=False)
    rows = read_table(path, expected).rows()
    if not rows:
        raise BadInputError(f"{path}: there is no row; give s_mm and Me_Nm in each.")
    s_m = [row.get("s_mm", from_plain, "a number") / 1000 for row in rows]
    return s_m, [row.get("Me_Nm", from_plain, "a number") for row in rows]
