"""EIBMs of one's own: as numbers, functions, arrays or tables."""

from __future__ import annotations

import textwrap
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from labrig.api.arguments import number, shown
from labrig.errors import BadArgumentError, BadInputError
from model.measurements import FloatArray, ModelError
from model.sheet.sheet_model import SheetModel
from model.sheet.stated import StatedEibm, with_eibm

# Me in N m: a number, a function of s_m, or (s_m, Me_Nm) with straight lines between the nodes
Row = Sequence[float] | FloatArray
Rows = tuple[Row, Row] | Sequence[Sequence[float]] | FloatArray
Eibm = float | Callable[[FloatArray], FloatArray] | Rows
LONGEST_RATIO = 10.0  # of the last place of a stated EIBM to the sheet's length
NODES = 51  # at which a function is taken, along the longest sheet; as of a fit
_EXAMPLE = "--eibm 2=36e-6 (N m), or --eibm 2=eibm.csv (columns s_mm, Me_Nm)"


def model_with_eibm(model: SheetModel, eibm: Mapping[float, Eibm] | None) -> SheetModel:
    """Return a model with the EIBM of some voltages replaced; raises ModelError."""
    voltages_of(eibm)
    if not eibm:
        return model
    length_m = max((one.sheet.free_length_m for one in model.sheets.values()), default=0.0)
    return with_eibm(model, stated_by_voltage("eibm", eibm, length_m))


def voltages_of(eibm: Mapping[float, Eibm] | None) -> list[float]:
    """Return the voltages of EIBMs. Raises BadInputError where they are not given by voltage."""
    if not isinstance(eibm, Mapping | None):  # a caller may give anything
        raise BadArgumentError(
            f"eibm {shown(eibm)}: EIBMs by voltage are needed, such as {{2.0: 36e-6}}.", "eibm"
        )
    return [number("eibm", voltage_V) for voltage_V in eibm or ()]


def stated_by_voltage(
    name: str, eibm: Mapping[float, Eibm], length_m: float
) -> dict[float, StatedEibm]:
    """Return EIBMs as the model takes them; `name`: of the argument, for errors."""
    by_voltage = ((number(name, volts), one) for volts, one in eibm.items())
    return {volts: stated(volts, one, length_m) for volts, one in by_voltage}


def stated(voltage_V: float, eibm: Eibm, length_m: float) -> StatedEibm:
    """Return an EIBM as the model takes it; a function is taken from 0 to `length_m`."""
    if callable(eibm):
        s_m = np.linspace(0.0, length_m, NODES)
        return s_m, _along(voltage_V, _called(voltage_V, eibm, s_m), s_m)
    whole = _numbers(eibm)
    if whole is not None and whole.ndim == 0:
        return float(whole)
    parts = [_numbers(part) for part in eibm] if isinstance(eibm, Iterable) else []
    if len(parts) != 2 or any(part is None or part.ndim != 1 for part in parts):
        raise ModelError(
            f"the EIBM at {voltage_V:+g} V must be a number in N m, a function of s_m, or a pair"
            " (s_m, Me_Nm) of equally long rows"
        )
    s_m, values = (np.asarray(part, dtype=np.float64) for part in parts)
    _require_along_the_sheet(voltage_V, s_m, length_m)
    return s_m, values


def _numbers(given: object) -> FloatArray | None:
    """Return a number or a row of them; None for what is neither."""
    try:
        found = np.asarray(given)
    except ValueError:  # rows of different lengths
        return None
    return found.astype(np.float64) if found.dtype.kind in "iuf" else None


def _called(voltage_V: float, eibm: Callable[[FloatArray], FloatArray], s_m: FloatArray) -> object:
    """Return what somebody's function makes of the places. Raises ModelError for its fault."""
    try:
        return eibm(s_m)
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        where = (
            f" in {Path(frames[1].filename).name}, line {frames[1].lineno}" if frames[1:] else ""
        )
        raise ModelError(
            f"the function of the EIBM at {voltage_V:+g} V failed{where}: {type(error).__name__}:"
            f" {textwrap.shorten(str(error), 120)}; it is called with an array of places s_m"
        ) from error


def _along(voltage_V: float, found: object, s_m: FloatArray) -> FloatArray:
    """Return a function's values at the places; one number is that everywhere."""
    values = _numbers(found)
    if values is None or values.shape not in ((), (1,), s_m.shape):
        raise ModelError(
            f"the function of the EIBM at {voltage_V:+g} V returned {shown(found)}; it must return"
            f" a number, or as many as there are places s_m ({len(s_m)})"
        )
    return np.broadcast_to(values, s_m.shape)


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
