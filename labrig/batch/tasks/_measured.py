"""What the tasks share that fit something: measurements of an input, and columns of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from labrig.batch.contract import BatchInput, InputKind, Measure, option

if TYPE_CHECKING:
    from model import Measurements, SheetModel

MEASURES = (
    Measure(column="B_Nm2", title="bending stiffness B", unit="µN·m²", scale=1e6),
    Measure(column="EIBM_Nm", title="EIBM", unit="µN·m", scale=1e6),
)


def columns_option() -> Any:
    """Return the option that says which column of a table is which of labrig's."""
    text = (
        "the name of a column in the tables, such as force_mN=F; repeatable, also for one column: "
        "each table takes the first name that it has"
    )
    return option(text, default=(), metavar="OURS=THEIRS")


def values_option() -> Any:
    """Return the option that says what no column says."""
    text = "a column that is the same in all lines, such as configuration=long; repeatable"
    return option(text, default=(), metavar="OURS=VALUE", flag="--value")


def ignore_option() -> Any:
    """Return the option that leaves a column of a table out."""
    text = "a column of the tables to leave out; repeatable"
    return option(text, default=(), metavar="THEIRS")


def measurements_of(
    source: BatchInput,
    columns: Sequence[str] = (),
    values: Sequence[str] = (),
    ignore: Sequence[str] = (),
) -> Measurements:
    """Return what was measured; a session that is not analysed yet is analysed, and keeps it.

    `columns`, `values` and `ignore` say what names in tables mean.
    """
    if source.kind is InputKind.TABLES:
        from labrig.config import load_sheet
        from labrig.session import column_names, read_tables

        tables = source.tables
        return read_tables(
            load_sheet(source.path), tables["forces"], tables["curves"], tables["signals"],
            names=column_names(columns, values, ignore),
        )  # fmt: skip
    from labrig.report.data.findings import measured

    return measured(source.path, _quiet, _quiet, processes=1)


def _quiet(*_: object) -> None:
    pass


def columns_about(source: BatchInput) -> dict[str, Any]:
    """Return when a session began, and of which sample it is; nothing of tables."""
    if source.kind is not InputKind.SESSION:
        return {"started": None, "sample": None}
    from labrig.session import open_session

    with open_session(source.path) as session:
        sample = session.about.sample
        return {"started": session.started or None, "sample": sample.identity if sample else None}


def columns_of(
    model: SheetModel, measurements: Measurements, stiffness_Nm2: float | None
) -> dict[str, Any]:
    """Return the columns of B and EIBM, with sigma, by configuration and voltage.

    The EIBM of one that varies along the sheet is its mean, whose sigma a model does not hold.
    Without a force only EIBM/B is measured: such a configuration has none of these columns unless
    `stiffness_Nm2` states its B. `without_force` names it.
    """
    weighed = {
        c.configuration
        for c in measurements.conditions
        if c.position_m is not None and c.used()
    }  # fmt: skip
    found: dict[str, Any] = {"without_force": sorted(model.sheets.keys() - weighed)}
    for name, one in model.sheets.items():
        if name not in weighed and stiffness_Nm2 is None:
            continue
        found[f"B_Nm2[{name}]"], found[f"B_sigma_Nm2[{name}]"] = one.B.value, one.B.sigma
        for volts, along in sorted(one.eibm.items()):
            where = f"{name}, {volts:+g} V"
            found[f"EIBM_Nm[{where}]"] = one.mean_eibm(volts)
            constant = len(along.sigma) == 1
            found[f"EIBM_sigma_Nm[{where}]"] = float(along.sigma[0]) if constant else None
    return found


def fit_something() -> None:
    """Fit a small sheet, so that what fits need is compiled."""
    from model import fit

    fit(_small_sheet())


def diagnose_something() -> None:
    """Diagnose the same."""
    from model.discrepancy import diagnose

    diagnose(_small_sheet())


def _small_sheet() -> Measurements:
    import numpy as np

    from labrig.batch.tasks._simulated import Simulated, simulated
    from model import Along, ConfiguredSheet, Parameter, SheetGeometry, SheetModel

    sheet = SheetGeometry(
        configuration="small", free_length_m=0.05, width_m=0.011, thickness_m=2e-4,
        elongation_m=0.0, arc_radius_m=0.04, arc_origin_rad=0.0,
        initial_curvature=(np.zeros(1), np.zeros(1)),
    )  # fmt: skip
    rest = Along(np.zeros(1), np.zeros(1), np.zeros(1), "1/m")
    eibm = {
        volts: Along.constant(Parameter(value=moment, sigma=0.0, unit="N m"))
        for volts, moment in ((2.0, 3e-5), (-2.0, -3e-5))
    }
    one = ConfiguredSheet(sheet, Parameter(value=1.2e-6, sigma=0.0, unit="N m^2"), rest, eibm)
    return simulated(SheetModel(sheets={"small": one}), Simulated(positions_m=(0.0, 0.01, 0.02)))
