"""B and EIBM of each set-up compared with the common ones, as a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from labrig.report.data.models import CONSTANT
from labrig.report.data.selection import place
from labrig.report.parts.table import Table, volts, with_sigma
from model import Measurements, Parameter
from model.identification.fit_result import Fit
from model.identification.mounting import MountingParameters

Run = tuple[str, float | None, int, int]  # configuration, position, mounting, run


def sessions_of_runs(
    whole: Measurements, parts: Sequence[Measurements], names: Sequence[str]
) -> dict[Run, str]:
    """Which session each run of `whole` is from, whose conditions are those of `parts` in turn.

    A position approached from above may have been fitted as a run of its own, the next one.
    """
    of = [name for one, name in zip(parts, names, strict=True) for _ in one.conditions]
    each = list(zip(whole.conditions, of, strict=True))
    from_above = {
        (c.configuration, c.position_m, c.mounting, c.run + 1): name
        for c, name in each
        if c.approach == "down"
    }
    return from_above | {
        (c.configuration, c.position_m, c.mounting, c.run): name for c, name in each
    }


def by_run_table(
    fit: Fit, found: Sequence[MountingParameters], sessions: Mapping[Run, str]
) -> Table:
    """Return a row for each set-up, below the common values of its configuration."""
    driven = sorted({v for one in fit.configurations.values() for v in one.eibm}, reverse=True)
    columns = ["set-up", "B, µN·m²", "difference, %"]
    for voltage in driven:
        columns += [f"{CONSTANT} {volts(voltage)}, µN·m", "difference, %"]
    rows = []
    for name, common in fit.configurations.items():
        rows.append(_row(f"{name}, all", common.B, common.eibm, driven))
        times: Counter[str] = Counter()
        for one in found:
            if one.configuration != name:
                continue
            session = sessions.get((name, one.position_m, one.mounting, one.run), "")
            text = ", ".join(filter(None, [name, place(one.position_m), session]))
            times[text] += 1
            again = f" ({times[text]})" if times[text] > 1 else ""
            rows.append(_row(text + again, one.B, one.eibm, driven, common.B, common.eibm))
    note = (
        "Common value and the most likely random effect of each set-up in the joint fit, which is "
        "drawn towards 0 (shrinkage). Difference: from the common value. ± one standard "
        "uncertainty at the estimated scatter."
    )
    return Table(
        title="B and EIBM of each set-up", columns=tuple(columns), rows=tuple(rows), note=note
    )


def _row(
    text: str,
    B: Parameter,
    eibm: Mapping[float, Parameter],
    driven: Sequence[float],
    common_B: Parameter | None = None,
    common_eibm: Mapping[float, Parameter] | None = None,
) -> tuple[str, ...]:
    cells = [text, *_cells(B, common_B)]
    for voltage in driven:
        cells += _cells(eibm.get(voltage), (common_eibm or {}).get(voltage))
    return tuple(cells)


def _cells(here: Parameter | None, common: Parameter | None) -> list[str]:
    """In millionths, and how far off the common value it is."""
    if here is None:
        return ["-", "-"]
    off = ""
    if common is not None and common.value:
        off = f"{100.0 * (here.value / common.value - 1.0):+.1f}"
    return [with_sigma(1e6 * here.value, 1e6 * here.sigma), off]
